//! A planned run: a pilot, and what it tells.

use std::path::Path;

use super::{Bed, Run};
use crate::budget::{Budget, Origin};
use crate::error::Error;
use crate::library::Library;
use crate::plan::{PILOT, Plan};
use crate::scene::{Collision, Packing, Scene, SceneGeometry};
use crate::signature;
use crate::table::Table;
use crate::words;

impl Run<'_> {
    /// Says in the record that the stages from there on were those of a pilot.
    fn call_pilot(&mut self, begun: usize) {
        for stage in &mut self.record.stages[begun..] {
            if !stage.name.starts_with("pilot ") {
                stage.name.insert_str(0, "pilot ");
            }
        }
    }

    /// As many packings as the tolerance takes, dropped until their fines touch if it takes that.
    pub(super) fn planned(
        &mut self,
        scene: &Scene,
        packing: &Packing,
        library: Option<&Library>,
        path: &Path,
        wavelengths_um: &[f64],
    ) -> Result<(Vec<Bed>, Vec<Table>, Plan), Error> {
        let tolerance = self.options.tolerance;
        let begun = self.record.stages.len();
        let (mut scene, mut packing) = (scene.clone(), packing.clone());
        let made = |run: &mut Self, scene: &Scene, packing: &Packing| {
            let mut beds = run.drop(scene, packing, library, path)?;
            let tables = run.trace(&mut beds)?;
            Ok::<_, Error>((beds, tables))
        };
        let planned = |tables: &[Table], packing: &Packing| {
            let bands = signature::evaluate(tables, wavelengths_um)?;
            let budget = Budget::new(tables, &bands, Origin::of(packing))?;
            let plan = Plan::new(&bands, &budget, tolerance);
            eprintln!("plan: {}", words::plan(&plan, tolerance));
            Ok::<_, Error>(plan)
        };
        let (mut beds, mut tables) = made(self, &scene, &packing)?;
        let mut plan = planned(&tables, &packing)?;
        if plan.touching {
            self.call_pilot(begun);
            packing.drop.collision = Collision::HullThenFines;
            scene.geometry = SceneGeometry::Packing(packing.clone());
            (beds, tables) = made(self, &scene, &packing)?;
            plan = Plan { touching: true, ..planned(&tables, &packing)? };
        }
        if plan.packings > PILOT {
            self.call_pilot(begun);
            // Those of the pilot come from the cache.
            self.packings = plan.packings;
            (beds, tables) = made(self, &scene, &packing)?;
        }
        Ok((beds, tables, plan))
    }
}

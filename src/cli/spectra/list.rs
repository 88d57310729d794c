//! `soilsig spectra list`.

use super::show::summary;
use crate::cli::Context;
use crate::spectrum::{self, Spectrum};
use crate::support::error::Error;

pub(super) fn run(context: &Context) -> Result<(), Error> {
    for shipped in &spectrum::all() {
        let name = match shipped {
            Spectrum::Fresnel(constants, _) => format!("fresnel:{constants}"),
            _ => shipped.name().to_owned(),
        };
        context.print(&format!("{name:<32}{}\n", summary(shipped)))?;
    }
    Ok(())
}

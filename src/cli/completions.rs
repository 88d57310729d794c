//! `soilsig completions`: for shells.

use clap::CommandFactory as _;
use clap_complete::Shell;

use super::{Cli, Context, Outcome};

/// Prints completions for a shell
#[derive(clap::Args)]
pub struct Args {
    /// Shell
    shell: Shell,
}

pub fn run(args: &Args, context: &Context) -> Outcome {
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "soilsig", &mut text);
    context.print(&String::from_utf8_lossy(&text))?;
    Ok(None)
}

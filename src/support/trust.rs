//! Whether a folder is the user's own: nobody else may have put files into it.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// Owner of files that this container does not know.
const UNMAPPED: u32 = 65_534;

/// What others may do to a folder, in words; `None` if only this user and root can change it.
///
/// # Errors
/// The folder cannot be looked at.
pub fn doubt(folder: &Path) -> io::Result<Option<String>> {
    let named = std::path::absolute(folder)?;
    let real = folder.canonicalize()?;
    let (me, my_group) = (nix::unistd::geteuid().as_raw(), nix::unistd::getegid().as_raw());
    let now = real.metadata()?;
    if now.uid() != me {
        return Ok(Some(format!("it belongs to another user (uid {})", now.uid())));
    }
    if now.mode() & 0o022 != 0 {
        let mode = now.mode() & 0o777;
        return Ok(Some(format!("others may write to it (mode {mode:o})")));
    }
    // Who may rename a folder above may put another in its place.
    for above in named.ancestors().skip(1).chain(real.ancestors().skip(1)) {
        let now = above.metadata()?;
        let sticky = now.mode() & 0o1000 != 0;
        let by_all = now.mode() & 0o002 != 0;
        let by_group = now.mode() & 0o020 != 0 && ![0, my_group].contains(&now.gid());
        let above = above.display();
        if ![0, me, UNMAPPED].contains(&now.uid()) {
            return Ok(Some(format!("{above} belongs to another user (uid {})", now.uid())));
        } else if (by_all || by_group) && !sticky {
            let mode = now.mode() & 0o777;
            return Ok(Some(format!("others may write to {above} (mode {mode:o})")));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::fs::{self, Permissions};
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    #[test]
    fn a_folder_that_others_may_write_to_is_in_doubt() {
        let all = tempfile::tempdir().expect("a temporary folder");
        let inner = all.path().join("above/cache");
        fs::create_dir_all(&inner).expect("made");
        let set = |folder: &Path, mode| {
            fs::set_permissions(folder, Permissions::from_mode(mode)).expect("set");
        };
        let above = inner.parent().expect("above");
        for (of_above, of_inner, doubted) in [
            (0o755, 0o700, false),
            (0o755, 0o755, false),
            (0o1777, 0o700, false),
            (0o755, 0o775, true),
            (0o755, 0o757, true),
            (0o777, 0o700, true),
        ] {
            set(above, of_above);
            set(&inner, of_inner);
            let found = doubt(&inner).expect("there");
            assert_eq!(found.is_some(), doubted, "{of_above:o} {of_inner:o}: {found:?}");
        }
    }
}

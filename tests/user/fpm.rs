//! Hosts that are built by fpm.

use crate::common::{in_crate, run, there_is, tool};
use crate::{force, prefix, project, rpath};
use std::fs;
use std::process::Command;

#[test]
fn a_fortran_project_depends_on_the_source_tree_and_links_the_installed_library() {
    let Some(fpm) = there_is("gfortran").then(|| tool("fpm")).flatten() else { return };
    let project = project("fpm", "user/fpm/bar");
    fs::create_dir(project.join("app")).unwrap();
    fs::rename(project.join("bar.f90"), project.join("app/main.f90")).unwrap();
    let sources = project.join("../perion");
    let _ = fs::remove_file(&sources);
    std::os::unix::fs::symlink(in_crate(""), sources).unwrap();
    // Archives for each package, or all in one: neither may be taken for the library.
    for kind in ["", "\n[library]\ntype = \"static\"\n"] {
        let manifest = fs::read_to_string(in_crate("tests/user/outside/fpm/fpm.toml")).unwrap();
        fs::write(project.join("fpm.toml"), manifest + kind).unwrap();
        let said = run(Command::new(&fpm)
            .arg("run")
            .current_dir(&project)
            .env("FPM_LDFLAGS", format!("-L{}/lib {}", prefix().display(), rpath())));
        assert_eq!(said.lines().last().map(str::trim), Some(force().trim()), "{said}");
    }
}

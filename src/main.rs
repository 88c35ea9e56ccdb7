//! The `raycell` program; all of it lives in [`raycell::cli`].

fn main() -> std::process::ExitCode {
    raycell::cli::run()
}

//! The commands: check everything that was given, do the work, only then write.

use super::flags::{self, Command};
use super::log::Log;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, device, device::BackendChoice};
use crate::output::report::AdapterReport;
use crate::output::{image, ply, points, report};
use crate::params::{Direct, Params};
use crate::progress::{Event, Flow};
use crate::scene::Scene;
use crate::solution::{Answer, Camera, Solution, Status, SurfacePoint};
use crate::{Backend, bake};
use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

pub fn run(command: Command) -> Result<()> {
    match command {
        Command::Bake(flags) => bake_scene(flags),
        Command::Query(flags) => query(flags),
        Command::Render(flags) => render(flags),
        Command::Adapters(flags) => adapters(flags),
    }
}

fn bake_scene(flags: flags::Bake) -> Result<()> {
    let begin = Instant::now();
    let params = params(&flags.network)?;
    let camera = camera(&flags.camera)?;
    let points_in = flags.points.as_deref().map(points::read).transpose()?;
    let scene = Scene::load(&flags.scene)?;
    let load = begin.elapsed();
    check_folder(&flags.output)?;
    let mut log = Log::new(flags.device.quiet);
    let machine = Machine::open(&flags.device, &log)?;
    let backend = &machine.backend;

    let stop = interrupt();
    let baked = bake(backend, &scene, &params, &mut |event| heed(&mut log, &stop, event));
    let mut solution = machine.judge("the bake", baked)?;

    // Everything is read out before the first file appears.
    let begin_readout = Instant::now();
    log.event(&Event::Stage { name: "readout" });
    let answers =
        points_in.as_ref().map(|p| solution.query_with(backend, p, &mut |event| heed(&mut log, &stop, event))).transpose();
    let answers = machine.judge("the points", answers)?;
    let picture = camera.map(|c| solution.render_with(backend, &c, &mut |event| heed(&mut log, &stop, event))).transpose();
    let picture = machine.judge("the picture", picture)?;
    let mesh = flags.vertices.then(|| solution.vertices_with(backend, &mut |event| heed(&mut log, &stop, event))).transpose();
    let mesh = machine.judge("the vertices", mesh)?;
    log.finish();
    let readout = begin_readout.elapsed();

    let dir = &flags.output;
    std::fs::create_dir_all(dir).map_err(|source| Error::Write { path: dir.clone(), source })?;
    let wrote = |name: &str, note: &str| log.line(&format!("wrote {}{note}", dir.join(name).display()));
    if let (Some(p), Some(a)) = (&points_in, &answers) {
        points::write(&dir.join("points.csv"), p, a)?;
        wrote("points.csv", &off_surface(a));
    }
    if let Some(mesh) = &mesh {
        ply::write(&dir.join("vertices.ply"), mesh)?;
        wrote("vertices.ply", "");
    }
    if let Some(picture) = &picture {
        image::write(&dir.join("picture.exr"), picture, None)?;
        wrote("picture.exr", " (linear radiance)");
        let tone = image::write(&dir.join("picture.png"), picture, flags.camera.exposure)?;
        wrote("picture.png", &tone.map_or(String::new(), |t| format!(" ({t})")));
    }
    solution.save(&dir.join("solution.rcell"))?;
    wrote("solution.rcell", "");
    let report = solution.report_mut();
    report.adapter = machine.adapter;
    report.memory_bytes.host = host_bytes();
    let seconds = &mut report.seconds;
    seconds.load = Some(load.as_secs_f64());
    seconds.readout = Some(readout.as_secs_f64());
    seconds.total = Some(begin.elapsed().as_secs_f64());
    report::write(&dir.join("report.json"), solution.report())?;
    wrote("report.json", "");
    Ok(())
}

fn query(flags: flags::Query) -> Result<()> {
    let points_in: Vec<SurfacePoint> = points::read(&flags.points)?;
    let solution = Solution::load(&flags.solution)?;
    let mut log = Log::new(flags.device.quiet);
    let machine = Machine::open(&flags.device, &log)?;
    log.event(&Event::Stage { name: "readout" });
    let stop = interrupt();
    let answers = solution.query_with(&machine.backend, &points_in, &mut |event| heed(&mut log, &stop, event));
    let answers = machine.judge("the points", answers)?;
    log.finish();
    points::write(&flags.output, &points_in, &answers)?;
    log.line(&format!("wrote {}{}", flags.output.display(), off_surface(&answers)));
    Ok(())
}

fn render(flags: flags::Render) -> Result<()> {
    image::check_name(&flags.output)?;
    let camera = camera(&flags.camera)?.ok_or(Error::InvalidParam {
        name: "camera",
        value: "none".into(),
        range: "give --eye and --target, or --camera FILE",
    })?;
    let mut log = Log::new(flags.device.quiet);
    let stop = interrupt();
    let is_solution = flags.input.extension().is_some_and(|e| e.eq_ignore_ascii_case("rcell"));
    let (machine, solution) = if is_solution {
        let n = &flags.network;
        if n.seed.is_some() || n.rays.is_some() || n.cells.is_some() || n.direct.is_some() {
            log.warning("--seed, --rays, --cells and --direct shape a bake; this solution is already baked");
        }
        let solution = Solution::load(&flags.input)?;
        (Machine::open(&flags.device, &log)?, solution)
    } else {
        let params = params(&flags.network)?;
        let scene = Scene::load(&flags.input)?;
        let machine = Machine::open(&flags.device, &log)?;
        let baked = bake(&machine.backend, &scene, &params, &mut |event| heed(&mut log, &stop, event));
        let solution = machine.judge("the bake", baked)?;
        (machine, solution)
    };
    log.event(&Event::Stage { name: "readout" });
    let picture = solution.render_with(&machine.backend, &camera, &mut |event| heed(&mut log, &stop, event));
    let picture = machine.judge("the picture", picture)?;
    log.finish();
    let tone = image::write(&flags.output, &picture, flags.camera.exposure)?;
    let note = tone.map_or(" (linear radiance)".into(), |t| format!(" ({t})"));
    log.line(&format!("wrote {}{note}", flags.output.display()));
    Ok(())
}

fn adapters(flags: flags::Adapters) -> Result<()> {
    let mut text = String::new();
    if let Some(choice) = choice(flags.device.backend) {
        for line in device::list_adapters(choice, flags.device.adapter.as_deref()) {
            let l = &line.limits;
            text += &format!(
                "{line}\n    buffer {} MiB, binding {} MiB, {} storage buffers a stage, {} invocations, {} KiB workgroup memory\n",
                l.max_buffer_size >> 20,
                l.max_storage_buffer_binding_size >> 20,
                l.max_storage_buffers_per_shader_stage,
                l.max_compute_invocations_per_workgroup,
                l.max_compute_workgroup_storage_size >> 10,
            );
        }
        if text.is_empty() {
            text += "no adapter; ci/setup installs a software driver on Debian and Ubuntu\n";
        }
    }
    text += "cpu: plain-Rust twin, slow, needs no driver, never chosen by auto (--backend cpu)\n";
    // A reader that has seen enough (head) is no error.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write { path: "stdout".into(), source: e }),
        _ => Ok(()),
    }
}

/// Shows an event, and heeds Ctrl-C.
fn heed(log: &mut Log, stop: &AtomicBool, event: &Event) -> Flow {
    log.event(event);
    if stop.load(Ordering::Relaxed) { Flow::Stop } else { Flow::Continue }
}

/// A flag that the first Ctrl-C raises; the second one ends the process.
fn interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let raised = stop.clone();
    // Where no handler can be set, Ctrl-C ends the process at once, as ever.
    let _ = ctrlc::set_handler(move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(super::code::INTERRUPTED.into());
        }
    });
    stop
}

fn params(flags: &flags::Network) -> Result<Params> {
    let default = Params::default();
    let params = Params {
        seed: flags.seed.unwrap_or(default.seed),
        rays: flags.rays.unwrap_or(default.rays),
        cells: flags.cells,
        direct: flags.direct.map_or(default.direct, |d| match d {
            flags::Direct::Exact => Direct::Exact,
            flags::Direct::Network => Direct::Network,
        }),
        ..default
    };
    params.check()?;
    Ok(params)
}

/// What a job runs on, and what a report says of it.
struct Machine {
    backend: Backend,
    adapter: Option<AdapterReport>,
    failure: Option<Arc<Mutex<Option<String>>>>,
}

impl Machine {
    fn open(flags: &flags::Device, log: &Log) -> Result<Machine> {
        let Some(choice) = choice(flags.backend) else {
            return Ok(Machine { backend: Backend::Cpu, adapter: None, failure: None });
        };
        let open = device::open(choice, flags.adapter.as_deref())?;
        let info = &open.info;
        let driver = [&info.driver, &info.driver_info].map(|s| s.trim()).join(" ").trim().to_string();
        log.line(&format!("running on {} ({:?}, {driver})", info.name, info.backend));
        let adapter = AdapterReport { name: info.name.clone(), backend: format!("{:?}", info.backend).to_lowercase(), driver };
        let gpu = Gpu::new(&open.device, &open.queue)?;
        Ok(Machine { backend: Backend::Gpu(Arc::new(gpu)), adapter: Some(adapter), failure: Some(open.failure) })
    }

    /// A result of this machine: where the device failed meanwhile, that is the error, whatever came of it.
    fn judge<T>(&self, stage: &str, result: Result<T>) -> Result<T> {
        let failure = self.failure.as_ref().and_then(|f| f.lock().unwrap_or_else(|e| e.into_inner()).clone());
        match failure {
            Some(why) => Err(Error::Device { stage: stage.into(), why }),
            None => result,
        }
    }
}

/// The graphics interface asked for; none for the twin.
fn choice(backend: flags::Backend) -> Option<BackendChoice> {
    match backend {
        flags::Backend::Auto => Some(BackendChoice::Auto),
        flags::Backend::Vulkan => Some(BackendChoice::Vulkan),
        flags::Backend::Metal => Some(BackendChoice::Metal),
        flags::Backend::Dx12 => Some(BackendChoice::Dx12),
        flags::Backend::Gl => Some(BackendChoice::Gl),
        flags::Backend::Cpu => None,
    }
}

/// Most memory this process has held, where the system tells.
fn host_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kb| kb * 1024)
}

/// Refuses a folder that cannot be one, before the work and without making it.
fn check_folder(path: &Path) -> Result<()> {
    if path.exists() && !path.is_dir() {
        let source = std::io::Error::from(std::io::ErrorKind::NotADirectory);
        return Err(Error::Write { path: path.into(), source });
    }
    Ok(())
}

fn off_surface(answers: &[Answer]) -> String {
    let n = answers.iter().filter(|a| a.status == Status::OffSurface).count();
    if n > 0 { format!(" ({n} of {} points are off every surface)", answers.len()) } else { String::new() }
}

/// The camera that flags and file describe; none where neither says a word.
fn camera(flags: &flags::Camera) -> Result<Option<Camera>> {
    let file = flags.camera.as_deref().map(camera_file).transpose()?;
    let refuse = |name, value: String, range| Err(Error::InvalidParam { name, value, range });
    if file.is_none() && flags.eye.is_none() && flags.target.is_none() {
        return Ok(None);
    }
    let file = file.unwrap_or_default();
    let (Some(eye), Some(target)) = (flags.eye.or(file.eye), flags.target.or(file.target)) else {
        return refuse("camera", "incomplete".into(), "give both an eye and a target");
    };
    let camera = Camera {
        eye,
        target,
        up: flags.up.or(file.up).unwrap_or([0.0, 1.0, 0.0]),
        vfov_degrees: flags.vfov.or(file.vfov).unwrap_or(40.0),
        width: flags.width.or(file.width).unwrap_or(512),
        height: flags.height.or(file.height).unwrap_or(512),
    };
    camera.check()?;
    match flags.exposure {
        Some(x) if !(x > 0.0 && x.is_finite()) => refuse("exposure", x.to_string(), "give a positive number"),
        _ => Ok(Some(camera)),
    }
}

#[derive(Default, serde::Deserialize)]
struct CameraFile {
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    vfov: Option<f64>,
    width: Option<u32>,
    height: Option<u32>,
}

fn camera_file(path: &Path) -> Result<CameraFile> {
    #[derive(serde::Deserialize)]
    struct File {
        camera: CameraFile,
    }
    let text = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let file: File = serde_json::from_slice(&text).map_err(|e| Error::Format {
        path: path.into(),
        line: (e.line() > 0).then_some(e.line()),
        what: e.to_string(),
        cure: r#"a camera file holds {"camera": {"eye": [x,y,z], "target": [x,y,z], "up": [x,y,z], "vfov": degrees}}"#.into(),
    })?;
    Ok(file.camera)
}

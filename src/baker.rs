//! A bake inside a host that owns the frame: recorded slice by slice into the host's own commands.

use crate::bake::bake;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::gpu::Gpu;
use crate::gpu::frames::Frames;
use crate::gpu::stamps::Timer;
use crate::output::mesh::Mesh;
use crate::params::Params;
use crate::pass;
use crate::progress::{Event, Flow};
use crate::scene::Scene;
use crate::solution::{Camera, Solution};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Texels in a row of [`Baked::light_texture`].
pub const LIGHT_TEXTURE_WIDTH: u32 = 1024;

/// What a host can do now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ready {
    /// There is work to record: call [`Baker::encode`].
    Encode,
    /// The device or the bake's thread is at work; look again with the next frame.
    Wait,
    /// All is recorded and the result is there: submit what was recorded, and call [`Baker::finish`].
    Done,
}

/// What a finished bake hands to its host. Later passes may bind the buffers and textures at once: the
/// work that fills them was recorded before.
#[derive(Debug)]
#[non_exhaustive]
pub struct Baked {
    /// The solution, for queries, files and more pictures.
    pub solution: Solution,
    /// Radiosity at the corners of the scene's faces, three a face in the order of [`Scene::faces`]:
    /// a `vec4<f32>` each, W/m² in linear Rec.709 and 1; all 0 for a face that was dropped (no area,
    /// duplicate). Usage: storage, vertex, copy.
    pub light: wgpu::Buffer,
    /// The same numbers as `Rgba32Float` texels, [`LIGHT_TEXTURE_WIDTH`] a row: corner `i` stands at
    /// `(i % width, i / width)`. None where the device's textures are too small. Usage: sampled, copy.
    pub light_texture: Option<wgpu::Texture>,
    /// The lit mesh, for hosts that build their own vertices.
    pub mesh: Mesh,
    /// The picture that [`Baker::picture`] asked for: radiance, W/m²/sr, `Rgba32Float`. Usage: sampled, copy.
    pub picture: Option<wgpu::Texture>,
}

/// A bake that a host drives with its frames.
///
/// ```no_run
/// # fn frame(device: &wgpu::Device, queue: &wgpu::Queue, scene: &raycell::Scene) -> raycell::Result<()> {
/// use raycell::{Baker, Params, Ready};
/// let mut baker = Baker::new(device, queue, scene, Params::default())?;
/// loop {
///     let mut encoder = device.create_command_encoder(&Default::default()); // the host's frame
///     baker.encode(&mut encoder, std::time::Duration::from_millis(4))?;
///     queue.submit([encoder.finish()]);
///     if baker.poll_ready()? == Ready::Done {
///         let baked = baker.finish()?;
///         // bind baked.light in the next pass
///         return Ok(());
///     }
/// }
/// # }
/// # use raycell::wgpu;
/// ```
///
/// The bake's order of passes is that of [`bake()`], and so are its results, to the byte. It runs on a
/// thread of its own, which works out nodes and cells and sleeps while the device is at work; the
/// thread never submits and never polls. The methods here record and look, and return at once. For
/// its results to arrive the device must be polled, which every `Queue::submit` does too.
///
/// Where the device has [`wgpu::Features::TIMESTAMP_QUERY`], slices are timed by the device. Else they are timed by
/// when the host hears that they are done, and a host that looks less often than its budget gets
/// slices that fit between two looks.
#[derive(Debug)]
pub struct Baker {
    device: wgpu::Device,
    timer: Option<Timer>,
    frames: Arc<Frames>,
    job: Option<Job>,
    /// What the thread leaves behind.
    outcome: Arc<Mutex<Option<Result<Baked>>>>,
}

/// A bake that has not begun.
struct Job {
    scene: Scene,
    params: Params,
    picture: Option<Camera>,
    progress: Box<dyn FnMut(&Event) -> Flow + Send>,
}

impl Baker {
    /// Features the host's device needs: none. [`wgpu::Features::TIMESTAMP_QUERY`] is used where it is enabled.
    pub fn required_features() -> wgpu::Features {
        Gpu::required_features()
    }

    /// Limits the host's device needs; [`wgpu::Limits::default`] has them.
    pub fn required_limits() -> wgpu::Limits {
        Gpu::required_limits()
    }

    /// A bake on a host's device. Nothing runs before the first [`Baker::encode`] or [`Baker::poll_ready`].
    ///
    /// Errors: [`Error::Limit`] where the device was made with less than [`Baker::required_limits`], those
    /// of [`Params::check`] and [`Scene::check`].
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene, params: Params) -> Result<Baker> {
        Gpu::check_limits(device)?;
        params.check()?;
        scene.check()?;
        Ok(Baker {
            device: device.clone(),
            timer: Timer::new(device, queue),
            frames: Arc::default(),
            job: Some(Job { scene: scene.clone(), params, picture: None, progress: Box::new(|_| Flow::Continue) }),
            outcome: Arc::default(),
        })
    }

    /// Tells a closure what happens, on the bake's own thread; it may stop the bake. Set it before the bake begins.
    pub fn progress(mut self, tell: impl FnMut(&Event) -> Flow + Send + 'static) -> Baker {
        if let Some(job) = &mut self.job {
            job.progress = Box::new(tell);
        }
        self
    }

    /// Also asks for a picture. Set it before the bake begins. Errors: those of [`Camera::check`].
    pub fn picture(mut self, camera: Camera) -> Result<Baker> {
        camera.check()?;
        if let Some(job) = &mut self.job {
            job.picture = Some(camera);
        }
        Ok(self)
    }

    /// Records the next slice of work, about `budget` long on the device, and says whether there was any.
    ///
    /// The host must submit the encoder's commands, and encoders in the order in which they were recorded.
    /// Never waits for the device. Errors: [`Error::Limit`] where the system gives no thread.
    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, budget: Duration) -> Result<bool> {
        self.start()?;
        Ok(self.frames.record(&self.device, self.timer.as_ref(), encoder, budget))
    }

    /// Whether there is work to record, or a result. Never waits.
    ///
    /// Errors: whatever ended the bake: those of [`bake()`], [`Error::Cancelled`] where the progress closure stopped it.
    pub fn poll_ready(&mut self) -> Result<Ready> {
        self.start()?;
        let mut outcome = self.outcome.lock().unwrap_or_else(|e| e.into_inner());
        if matches!(*outcome, Some(Err(_))) {
            // Said once; afterwards the bake is as good as stopped.
            return match outcome.replace(Err(Error::Cancelled)) {
                Some(Err(e)) => Err(e),
                _ => Err(Error::Cancelled),
            };
        }
        Ok(match (self.frames.ready(), outcome.is_some() && self.frames.empty()) {
            (true, _) => Ready::Encode,
            (false, true) => Ready::Done,
            (false, false) => Ready::Wait,
        })
    }

    /// Takes the result. Errors: whatever ended the bake; [`Error::Cancelled`] before [`Ready::Done`].
    pub fn finish(self) -> Result<Baked> {
        self.outcome.lock().unwrap_or_else(|e| e.into_inner()).take().unwrap_or(Err(Error::Cancelled))
    }

    /// Starts the bake's thread, once.
    fn start(&mut self) -> Result<()> {
        let Some(job) = self.job.take() else { return Ok(()) };
        let (device, frames, outcome) = (self.device.clone(), self.frames.clone(), self.outcome.clone());
        let work = move || {
            let result = Gpu::hosted(&device, frames, &pass::kernels(&device, &job.scene)).and_then(|gpu| job.run(Arc::new(gpu)));
            *outcome.lock().unwrap_or_else(|e| e.into_inner()) = Some(result);
        };
        let started = std::thread::Builder::new().name("raycell".into()).spawn(work);
        started.map(drop).map_err(|_| Error::Limit {
            what: "a bake".into(),
            limit: "number of threads",
            need: 1,
            have: 0,
            cure: "close other programs",
        })
    }
}

impl Drop for Baker {
    /// Ends the bake; its thread stops at its next step.
    fn drop(&mut self) {
        self.frames.close();
    }
}

impl Job {
    fn run(mut self, gpu: Arc<Gpu>) -> Result<Baked> {
        let backend = Backend::Gpu(gpu.clone());
        let solution = bake(&backend, &self.scene, &self.params, &mut self.progress)?;

        // Lay the light out by the scene's own corners.
        let mesh = solution.faces_with(&backend, &mut self.progress)?;
        let mut texels = vec![[0f32; 4]; 3 * self.scene.faces.len()];
        for (face, &source) in mesh.faces.iter().zip(&mesh.sources) {
            for (corner, &v) in face.iter().enumerate() {
                let [r, g, b] = mesh.vertices[v as usize].b;
                texels[3 * source as usize + corner] = [r, g, b, 1.0];
            }
        }
        let light = gpu.publish("light", &texels)?;
        let rows = (texels.len() as u32).div_ceil(LIGHT_TEXTURE_WIDTH);
        let light_texture = if rows <= gpu.device.limits().max_texture_dimension_2d {
            texels.resize((rows * LIGHT_TEXTURE_WIDTH) as usize, [0.0; 4]);
            Some(gpu.texture("light", LIGHT_TEXTURE_WIDTH, &texels)?)
        } else {
            None
        };

        let picture = match &self.picture {
            Some(camera) => {
                let image = solution.render_with(&backend, camera, &mut self.progress)?;
                let texels: Vec<[f32; 4]> = image.rgb.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
                Some(gpu.texture("picture", image.width, &texels)?)
            }
            None => None,
        };
        let mesh = solution.drawn(mesh);
        Ok(Baked { solution, light, light_texture, mesh, picture })
    }
}

impl std::fmt::Debug for Job {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("Job").field("scene", &self.scene.name).finish_non_exhaustive()
    }
}

//! Each GPU pass against its plain-Rust twin, at awkward sizes.
//!
//! Without any adapter the tests pass with a note, unless `RAYCELL_REQUIRE_GPU` is set.

use raycell::gpu::device::{BackendChoice, list_adapters, open};
use raycell::gpu::sentinel::{self, Counts};
use raycell::gpu::{Gpu, LIGHT};
use raycell::{Error, wgpu};

/// A device, or a note that there is none.
fn gpu() -> Option<Gpu> {
    match open(BackendChoice::Auto, None) {
        Ok(open) => {
            eprintln!("on {} ({:?}, {} {})", open.info.name, open.info.backend, open.info.driver, open.info.driver_info);
            Some(Gpu::new(&open.device, &open.queue).unwrap())
        }
        Err(e) => {
            assert!(std::env::var_os("RAYCELL_REQUIRE_GPU").is_none(), "{e}");
            eprintln!("skipped: {e}");
            None
        }
    }
}

/// Sizes that every cheap pass is tried at: empty, around a workgroup, ragged, beyond 65,535 workgroups.
const SIZES: [usize; 7] = [0, 1, 63, 64, 65, 10_007, 65_535 * 64 + 77];

#[test]
fn dispatches_reach_every_item_once() {
    let Some(gpu) = gpu() else { return };
    for n in SIZES {
        for chunk in [LIGHT, u32::MAX] {
            let n = n as u32;
            assert_eq!(sentinel::count(&gpu, n, 3, chunk).unwrap(), Counts::expected(n, 3));
        }
    }
}

#[test]
fn buffers_hold_what_was_written() {
    let Some(gpu) = gpu() else { return };
    for n in SIZES {
        let data: Vec<u32> = (0..n as u32).map(|i| i.wrapping_mul(2654435761)).collect();
        let vec = gpu.upload("data", &data).unwrap();
        assert_eq!(gpu.read(&vec).unwrap(), data);
        // Odd bytes survive the padding to four.
        let bytes: Vec<u8> = data.iter().take(4099).map(|&x| x as u8).collect();
        let vec = gpu.alloc::<u32>("odd", bytes.len().div_ceil(4)).unwrap();
        assert_eq!(gpu.read(&vec).unwrap(), vec![0; bytes.len().div_ceil(4)]);
    }
}

#[test]
fn too_large_a_buffer_is_a_typed_error() {
    let Some(gpu) = gpu() else { return };
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    let e = gpu.alloc::<u64>("huge", limit as usize / 8 + 1).unwrap_err();
    assert!(matches!(e, Error::Limit { limit: "max_storage_buffer_binding_size", .. }), "{e}");
    let short = gpu.alloc::<u32>("short", 3).unwrap();
    assert!(matches!(gpu.write(&short, 2, &[1, 2]), Err(Error::Limit { .. })));
}

#[test]
fn an_unknown_adapter_is_a_typed_error_that_lists_what_there_is() {
    let e = open(BackendChoice::Auto, Some("no such adapter")).unwrap_err();
    let Error::NoDevice { why } = &e else { panic!("{e}") };
    for line in list_adapters(BackendChoice::Auto, None) {
        assert!(why.contains(&line.info.name), "{why}");
    }
}

#[test]
fn a_poor_device_is_refused_and_a_destroyed_one_fails_typed() {
    let Some(gpu) = gpu() else { return };
    gpu.device.destroy();
    let result = gpu.upload("data", &[1u32, 2, 3]).and_then(|v| gpu.read(&v));
    assert!(matches!(result, Err(Error::Device { .. })), "{result:?}");
    // A new device works as before.
    let open = open(BackendChoice::Auto, None).unwrap();
    let limits = open.device.limits();
    assert!(limits.max_storage_buffers_per_shader_stage >= 8);
    let _: wgpu::Limits = Gpu::required_limits();
    Gpu::new(&open.device, &open.queue).unwrap();
}

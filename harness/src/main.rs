//! The command line of tracebench.

use std::process::ExitCode;

fn main() -> ExitCode {
    leave_out_device_selection();
    tracebench_harness::cli::main()
}

/// Leaves out Mesa's device-select layer, which looks for a Wayland display and complains on stderr, twice a command, where
/// there is none. It only reorders devices, which tracebench does by itself; who has asked it for a device keeps it. wgpu always
/// asks for the extension that wakes the layer, and the Vulkan loader takes its orders from the environment alone.
#[allow(unsafe_code, reason = "the loader reads this process's environment, which can be changed in no other way")]
fn leave_out_device_selection() {
    if std::env::var_os("MESA_VK_DEVICE_SELECT").is_none() {
        // SAFETY: asked of the caller is that no other thread reads or writes the environment meanwhile. This is the first
        // thing that `main` does: there is no other thread yet.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}

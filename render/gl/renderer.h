#pragma once
/// Off-screen drawing through EGL. Only this folder includes EGL and GL, in its .cpp files.
#include <memory>
#include <string>
#include <vector>

#include "engine/io/frame.h"
#include "render/image/exr.h"
#include "render/look/camera.h"
#include "render/look/look_options.h"
#include "render/surface/surface.h"

namespace whorl {

/// An EGL device that was tried, and the outcome.
struct DeviceAttempt {
    std::string name;  ///< "device 0 (EGL_EXT_device_drm)", "surfaceless"
    bool hardware = false;
    bool works = false;
    std::string outcome;  ///< renderer and GL version, or the reason of the failure
};
/// Tries every device, for `whorl doctor`.
std::vector<DeviceAttempt> probe_devices();

/// Sets LP_NUM_THREADS to the number of threads of this run, unless it is already set. Mesa's software driver reads it when it creates its
/// first screen. Call this before any thread starts: the environment must not change while another thread starts a process.
void share_threads_with_software_driver();

/// Camera of the next image.
struct NextView {
    View view;
    float interval;  ///< simulated time until then [s]
};

/// Draws frames into images. Only the thread that created a renderer may use it.
class Renderer {
public:
    /// @throws EnvironmentError if no device works; it lists each attempt
    Renderer(int width, int height);
    ~Renderer();
    Renderer(Renderer&&) noexcept;

    /// Draws the fluid in the style of the look, the solids and the ground. The image has alpha if the background is transparent.
    Image draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view);
    /// Draws the layers for compositors, without text. If the look shows a field, only light and shadow.
    PictureLayers draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view, const NextView& next);
    /// Renderer and version as GL reports them.
    std::string device() const;

private:
    struct Device;
    std::unique_ptr<Device> device_;
};

}  // namespace whorl

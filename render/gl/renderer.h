#pragma once
/// Off-screen drawing through EGL. The only folder that includes EGL and GL (in its .cpp files).
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
    std::string outcome;  ///< renderer and GL version, or why it failed
};
/// Tries every device, for `whorl doctor`.
std::vector<DeviceAttempt> probe_devices();

/// Mesa's software driver takes its number of threads from the environment when its first screen is made. Call before there are threads:
/// nothing may change the environment while another thread starts a process.
void share_threads_with_software_driver();

/// Camera of the next image.
struct NextView {
    View view;
    float interval;  ///< s, simulated, until then
};

/// Draws frames into images. Belongs to the thread that made it.
class Renderer {
public:
    /// @throws EnvironmentError if no device works, with each attempt
    Renderer(int width, int height);
    ~Renderer();
    Renderer(Renderer&&) noexcept;

    /// Draws the fluid's surface (or its particles, after the look), the solids, and the ground. With alpha where the background is
    /// transparent.
    Image draw(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view);
    /// The image for compositors, without text. If the look colours the fluid by a field, only its light (and shadow).
    PictureLayers draw_layers(const Frame& frame, const Surface& surface, const LookOptions& look, const View& view, const NextView& next);
    /// Renderer and version of the GL in use.
    std::string device() const;

private:
    struct Device;
    std::unique_ptr<Device> device_;
};

}  // namespace whorl

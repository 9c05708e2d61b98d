#pragma once
/// An OpenGL context without a window, on the first EGL device that works.
#include <string>

#include "render/gl/renderer.h"

namespace whorl {

/// A current OpenGL core context of version 4.3 or newer, bound to the thread that made it.
class GlContext {
public:
    /// Tries the devices in order and uses the first that works.
    /// @throws EnvironmentError if none works; it lists each device with the reason
    GlContext();
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    void make_current() const;
    /// Renderer and version as GL reports them.
    const std::string& device() const { return device_; }

private:
    void* display_ = nullptr;
    void* context_ = nullptr;
    std::string device_;
};

}  // namespace whorl

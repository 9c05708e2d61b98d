#include "render/gl/context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <array>
#include <cstdlib>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"

namespace whorl {
namespace {

struct Candidate {
    std::string name;
    bool hardware = false;
    EGLenum platform;
    void* native;  ///< device; null: the platform's default display
};

struct Opened {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    std::string outcome;  ///< renderer and version, or the reason of the failure
    bool works() const { return context != EGL_NO_CONTEXT; }
};

std::string egl_error() {
    const EGLint code = eglGetError();
    if (code == EGL_NOT_INITIALIZED) return "EGL_NOT_INITIALIZED (no driver, or no permission on the device file)";
    if (code == EGL_BAD_MATCH) return "EGL_BAD_MATCH (OpenGL version not supported)";
    return fmt::format("EGL error {:#x}", code);
}

bool lists(const char* extensions, const std::string& name) {
    return extensions != nullptr && (" " + std::string(extensions) + " ").find(" " + name + " ") != std::string::npos;
}

/// Reason why libEGL cannot be loaded, "" if it can. Checked first, because libepoxy ends the program if the library is missing.
std::string missing_library() {
    if (dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr) return {};
    const char* why = dlerror();
    return why == nullptr ? "no libEGL.so.1" : why;
}

/// Displays in the order of the attempts: hardware devices, Mesa without a surface (its software driver if there is no GPU), software
/// devices.
std::vector<Candidate> candidates() {
    if (!missing_library().empty()) return {};
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Candidate> all, software;
    if (lists(client, "EGL_EXT_platform_device") && (lists(client, "EGL_EXT_device_enumeration") || lists(client, "EGL_EXT_device_base"))) {
        std::array<EGLDeviceEXT, 16> devices{};
        EGLint count = 0;
        if (!eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count)) count = 0;
        for (EGLint i = 0; i < count; ++i) {
            const char* extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
            const bool is_software = lists(extensions, "EGL_MESA_device_software");
            const char* kind = is_software ? "software" : lists(extensions, "EGL_EXT_device_drm") ? "EGL_EXT_device_drm" : "hardware";
            (is_software ? software : all)
                .push_back({fmt::format("device {} ({})", i, kind), !is_software, EGL_PLATFORM_DEVICE_EXT, devices[i]});
        }
    }
    if (lists(client, "EGL_MESA_platform_surfaceless")) all.push_back({"surfaceless", false, EGL_PLATFORM_SURFACELESS_MESA, nullptr});
    all.insert(all.end(), software.begin(), software.end());
    return all;
}

void close(const Opened& opened) {
    if (opened.display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(opened.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (opened.works()) eglDestroyContext(opened.display, opened.context);
    // The display stays initialised: EGL shares one display per device within the process, and another renderer may be using it.
}

/// Opens a display and makes its context current.
Opened open(const Candidate& candidate) {
    Opened opened;
    const auto failed = [&](const std::string& why) {
        const std::string reason = why + ": " + egl_error();
        close(opened);
        return Opened{EGL_NO_DISPLAY, EGL_NO_CONTEXT, reason};
    };
    opened.display = eglGetPlatformDisplayEXT(candidate.platform, candidate.native, nullptr);
    if (opened.display == EGL_NO_DISPLAY) return failed("no display");
    if (!eglInitialize(opened.display, nullptr, nullptr)) return failed("eglInitialize failed");
    if (!eglBindAPI(EGL_OPENGL_API)) return failed("no desktop OpenGL");
    const std::array<EGLint, 7> wanted{
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    opened.context = eglCreateContext(opened.display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted.data());
    if (!opened.works()) return failed("no OpenGL 4.3 core context");
    if (!eglMakeCurrent(opened.display, EGL_NO_SURFACE, EGL_NO_SURFACE, opened.context))
        return failed("the context cannot be made current");
    const auto text = [](GLenum name) {
        const GLubyte* value = glGetString(name);
        return std::string(value == nullptr ? "?" : reinterpret_cast<const char*>(value));
    };
    opened.outcome = text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
    return opened;
}

}  // namespace

void share_threads_with_software_driver() { setenv("LP_NUM_THREADS", std::to_string(threads()).c_str(), 0); }

std::vector<DeviceAttempt> probe_devices() {
    share_threads_with_software_driver();
    std::vector<DeviceAttempt> attempts;
    for (const Candidate& candidate : candidates()) {
        const Opened opened = open(candidate);
        attempts.push_back({candidate.name, candidate.hardware, opened.works(), opened.outcome});
        close(opened);
    }
    return attempts;
}

GlContext::GlContext() {
    std::string tried = missing_library();
    for (const Candidate& candidate : candidates()) {
        Opened opened = open(candidate);
        if (opened.works()) {
            display_ = opened.display;
            context_ = opened.context;
            device_ = opened.outcome;
            return;
        }
        tried += (tried.empty() ? "" : "; ") + candidate.name + ": " + opened.outcome;
    }
    rlimit limit{};
    const bool limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur < rlim_t(4) << 30;
    throw EnvironmentError(
        "no OpenGL device can draw off-screen", tried,
        limited ? fmt::format("raise ulimit -v (it is {} kB, and a driver needs about 1 GB), or use --no-images", limit.rlim_cur / 1024)
                : "apt install libegl1 libgl1-mesa-dri (Mesa's software driver needs no GPU)");
}

GlContext::~GlContext() { close({display_, context_, ""}); }

void GlContext::make_current() const {
    WHORL_ASSERT(eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_), "only the thread that created a renderer may use it");
}

}  // namespace whorl

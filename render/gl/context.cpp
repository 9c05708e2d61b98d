#include "render/gl/context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#include <sys/resource.h>

#include <array>
#include <cstdlib>
#include <functional>
#include <utility>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"

namespace whorl {
namespace {

struct Candidate {
    std::string name;
    bool hardware = false;
    std::function<EGLDisplay()> display;
};

struct Opened {
    EGLDisplay display = EGL_NO_DISPLAY;
    EGLContext context = EGL_NO_CONTEXT;
    EGLSurface surface = EGL_NO_SURFACE;
    std::string outcome;  ///< renderer and version, or why it failed
    bool works() const { return context != EGL_NO_CONTEXT; }
};

std::string egl_error() {
    switch (const EGLint code = eglGetError()) {
        case EGL_SUCCESS: return "no error given";
        case EGL_NOT_INITIALIZED: return "EGL_NOT_INITIALIZED (no driver, or no permission on the device file)";
        case EGL_BAD_ALLOC: return "EGL_BAD_ALLOC";
        case EGL_BAD_CONFIG: return "EGL_BAD_CONFIG";
        case EGL_BAD_DISPLAY: return "EGL_BAD_DISPLAY";
        case EGL_BAD_MATCH: return "EGL_BAD_MATCH (OpenGL version not supported)";
        case EGL_BAD_PARAMETER: return "EGL_BAD_PARAMETER";
        case EGL_BAD_ATTRIBUTE: return "EGL_BAD_ATTRIBUTE";
        default: return fmt::format("EGL error {:#x}", code);
    }
}

bool lists(const char* extensions, const std::string& name) {
    return extensions != nullptr && (" " + std::string(extensions) + " ").find(" " + name + " ") != std::string::npos;
}

EGLDisplay platform_display(EGLenum platform, void* native) { return eglGetPlatformDisplayEXT(platform, native, nullptr); }

/// Why the library cannot be had, "" where it can: libepoxy would end the program.
std::string missing_library() {
    if (dlopen("libEGL.so.1", RTLD_LAZY | RTLD_LOCAL) != nullptr) return {};
    const char* why = dlerror();
    return why == nullptr ? "no libEGL.so.1" : why;
}

/// In the order in which they are tried: hardware devices, Mesa without a surface (its software driver where there is no GPU), software
/// devices, and whatever EGL calls the default display.
std::vector<Candidate> candidates() {
    if (!missing_library().empty()) return {};
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    std::vector<Candidate> hardware, software;
    if (lists(client, "EGL_EXT_platform_device") && (lists(client, "EGL_EXT_device_enumeration") || lists(client, "EGL_EXT_device_base"))) {
        std::array<EGLDeviceEXT, 16> devices{};
        EGLint count = 0;
        if (!eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count)) count = 0;
        for (EGLint i = 0; i < count; ++i) {
            const EGLDeviceEXT device = devices[i];
            const char* extensions = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
            const bool is_software = lists(extensions, "EGL_MESA_device_software");
            const char* kind = is_software ? "software" : lists(extensions, "EGL_EXT_device_drm") ? "EGL_EXT_device_drm" : "hardware";
            Candidate candidate{fmt::format("device {} ({})", i, kind), !is_software,
                                [device] { return platform_display(EGL_PLATFORM_DEVICE_EXT, device); }};
            (is_software ? software : hardware).push_back(std::move(candidate));
        }
    }
    std::vector<Candidate> all = std::move(hardware);
    if (lists(client, "EGL_MESA_platform_surfaceless"))
        all.push_back({"surfaceless", false, [] { return platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY); }});
    all.insert(all.end(), software.begin(), software.end());
    all.push_back({"default display", false, [] { return eglGetDisplay(EGL_DEFAULT_DISPLAY); }});
    return all;
}

void close(const Opened& opened) {
    if (opened.display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(opened.display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (opened.surface != EGL_NO_SURFACE) eglDestroySurface(opened.display, opened.surface);
    if (opened.context != EGL_NO_CONTEXT) eglDestroyContext(opened.display, opened.context);
    // The display is left initialised: EGL shares one per device in the whole process, and another renderer may be using it.
}

EGLContext core_context(EGLDisplay display, EGLConfig config) {
    for (const auto& [major, minor] : {std::pair{4, 5}, {4, 3}, {4, 1}, {3, 3}}) {
        const std::array<EGLint, 7> wanted{
            EGL_CONTEXT_MAJOR_VERSION,           major,   EGL_CONTEXT_MINOR_VERSION, minor, EGL_CONTEXT_OPENGL_PROFILE_MASK,
            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
        if (const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, wanted.data()); context != EGL_NO_CONTEXT)
            return context;
    }
    return EGL_NO_CONTEXT;
}

/// Opens a display and makes its context current.
Opened open(const Candidate& candidate) {
    Opened opened;
    const auto failed = [&](const std::string& why) {
        const std::string reason = why + ": " + egl_error();
        close(opened);
        opened = Opened{};
        opened.outcome = reason;
        return opened;
    };
    opened.display = candidate.display();
    if (opened.display == EGL_NO_DISPLAY) return failed("no display");
    if (!eglInitialize(opened.display, nullptr, nullptr)) {
        opened.display = EGL_NO_DISPLAY;
        return failed("eglInitialize failed");
    }
    if (!eglBindAPI(EGL_OPENGL_API)) return failed("no desktop OpenGL");
    const std::array<EGLint, 5> attributes{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint configs = 0;
    if (!eglChooseConfig(opened.display, attributes.data(), &config, 1, &configs) || configs == 0) {
        if (!lists(eglQueryString(opened.display, EGL_EXTENSIONS), "EGL_KHR_no_config_context"))
            return failed("no configuration with OpenGL");
        config = nullptr;
    }
    opened.context = core_context(opened.display, config);
    if (opened.context == EGL_NO_CONTEXT) return failed("no OpenGL 3.3 core context");
    if (!eglMakeCurrent(opened.display, EGL_NO_SURFACE, EGL_NO_SURFACE, opened.context)) {
        const std::array<EGLint, 5> one_pixel{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        if (config != nullptr) opened.surface = eglCreatePbufferSurface(opened.display, config, one_pixel.data());
        if (opened.surface == EGL_NO_SURFACE || !eglMakeCurrent(opened.display, opened.surface, opened.surface, opened.context))
            return failed("the context cannot be made current");
    }
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
            surface_ = opened.surface;
            device_ = opened.outcome;
            return;
        }
        tried += (tried.empty() ? "" : "; ") + candidate.name + ": " + opened.outcome;
    }
    rlimit limit{};
    const bool limited = getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur < rlim_t(4) << 30;
    throw EnvironmentError("no OpenGL device can draw off-screen", tried,
                           limited
                               ? fmt::format("allow more memory: ulimit -v is {} kB, and a driver takes about a gigabyte; or --no-images",
                                             limit.rlim_cur / 1024)
                               : "apt install libegl1 libgl1-mesa-dri (Mesa's software driver needs no GPU)");
}

GlContext::GlContext(GlContext&& other) noexcept
    : display_(std::exchange(other.display_, nullptr)), context_(std::exchange(other.context_, nullptr)),
      surface_(std::exchange(other.surface_, nullptr)), device_(std::move(other.device_)) {}

GlContext::~GlContext() { close({display_, context_, surface_ == nullptr ? EGL_NO_SURFACE : surface_, ""}); }

void GlContext::make_current() const {
    const EGLSurface surface = surface_ == nullptr ? EGL_NO_SURFACE : surface_;
    WHORL_ASSERT(eglMakeCurrent(display_, surface, surface, context_), "a renderer belongs to the thread that made it");
}

}  // namespace whorl

#include "tools/live/live_renderer.h"

#include <chrono>
#include <utility>

#include "engine/core/clock.h"
#include "engine/core/parallel.h"
#include "render/gl/renderer.h"
#include "render/look/camera.h"
#include "render/surface/foam.h"

namespace whorl {
namespace {

bool same(const SurfaceOptions& a, const SurfaceOptions& b) {
    return a.voxel == b.voxel && a.radius == b.radius && a.iso == b.iso && a.smoothing == b.smoothing && a.distance == b.distance;
}

}  // namespace

LiveRenderer::LiveRenderer(int width, int height, double frame) : width_(width), height_(height), interval_(frame) {
    share_threads_with_software_driver();
    thread_ = std::thread([this] {
        name_thread("draw");
        adopt_threads();
        try {
            work();
        } catch (...) {
            const std::lock_guard lock(mutex_);
            error_ = std::current_exception();
            closed_ = true;
            changed_.notify_all();
        }
    });
}

LiveRenderer::~LiveRenderer() {
    close();
    thread_.join();
}

void LiveRenderer::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
}

void LiveRenderer::show(Frame frame, std::uint64_t revision) {
    auto shared = std::make_shared<const State>(std::move(frame), revision);
    const std::lock_guard lock(mutex_);
    waiting_ = std::move(shared);
    changed_.notify_all();
}

bool LiveRenderer::wants_state_within(double seconds) const {
    const std::lock_guard lock(mutex_);
    return due_ < wall_seconds() + seconds;
}

void LiveRenderer::set_interval(double frame) {
    const std::lock_guard lock(mutex_);
    interval_ = frame;
}

void LiveRenderer::look(PictureOptions how, std::uint64_t revision) {
    const std::lock_guard lock(mutex_);
    if (look_ && revision < look_->revision) return;  // the loop may set an older look than the server has set already
    if (!look_ || revision > look_->revision) look_is_drawn_ = false;
    look_ = std::make_shared<const Look>(std::move(how), revision);
    changed_.notify_all();
}

void LiveRenderer::expect(std::uint64_t revision) {
    constexpr double most = 0.25;  // s: the run may be paused, or a step may take long
    const std::lock_guard lock(mutex_);
    if (revision > expected_) expected_ = revision, expected_until_ = wall_seconds() + most;
}

std::shared_ptr<const Picture> LiveRenderer::after(std::uint64_t number, double seconds) const {
    std::unique_lock lock(mutex_);
    const auto newer = [&] { return newest_ && newest_->number > number; };
    changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return closed_ || newer(); });
    return !closed_ && newer() ? newest_ : nullptr;
}

void LiveRenderer::work() {
    std::optional<Renderer> renderer(std::in_place, width_, height_);
    {
        const std::lock_guard lock(mutex_);
        device_ = renderer->device();
    }
    bool is_new = false;
    while (const auto state = next(is_new)) draw(renderer, state, is_new);
}

/// Waits for a state to draw. @param is_new false: the state was drawn before, with another look @return null after close()
std::shared_ptr<const LiveRenderer::State> LiveRenderer::next(bool& is_new) {
    std::unique_lock lock(mutex_);
    for (;;) {
        if (closed_) return nullptr;
        const double now = wall_seconds(), due = expected_ > shown_ ? std::max(due_, expected_until_) : due_;
        is_new = look_ && waiting_ && (waiting_->revision > shown_ || due <= now);
        if (is_new) {
            due_ = now + interval_;
            shown_ = waiting_->revision;
            return std::exchange(waiting_, nullptr);
        }
        if (look_ && drawn_ && !look_is_drawn_) return drawn_;
        constexpr double long_time = 3600;  // s
        changed_.wait_for(lock, std::chrono::duration<double>(waiting_ && look_ ? due - now : long_time));
    }
}

void LiveRenderer::draw(std::optional<Renderer>& renderer, std::shared_ptr<const State> state, bool is_new) {
    auto look = locked(mutex_, look_);
    const Frame& frame = state->frame;
    const double began = wall_seconds();
    const SurfaceOptions surface = look->how.surface;
    const bool field = shows_field(look->how.look);
    if (is_new || !same(surface, surface_of_) || (surface_.mesh.triangle.empty() && !field))
        surface_ = field ? Surface{} : build_surface(frame, surface, look->how.look.foam);
    surface_of_ = surface;
    const double surfaced = wall_seconds();
    {  // A state that shows no change itself makes way for one that does.
        const std::lock_guard lock(mutex_);
        if (newest_ && newest_->revisions.fluid == state->revision && waiting_ && waiting_->revision > state->revision) return;
    }
    // Use a look that was set meanwhile, if it needs no other surface.
    if (const auto now = locked(mutex_, look_); same(now->how.surface, surface) && shows_field(now->how.look) == field) look = now;
    View view = view_at(look->how.camera, frame.time, frame.domain_min, frame.domain_max);
    view.open = 0;  // no motion blur: the interval between images varies
    Image image = renderer->draw(frame, surface_, look->how.look, view);
    const double drawn = wall_seconds();

    const std::lock_guard lock(mutex_);
    drawn_ = state;
    look_is_drawn_ = look->revision == look_->revision;
    newest_ = std::make_shared<const Picture>(++pictures_, frame.number, frame.time, Revisions{state->revision, look->revision},
                                              std::move(image));
    times_["surface"] = {surfaced - began, 0, 1};
    times_["draw"] = {drawn - surfaced, 0, 1};
    changed_.notify_all();
}

StageTimes LiveRenderer::times() const {
    const std::lock_guard lock(mutex_);
    StageTimes all = times_;
    if (newest_ && newest_->encode_seconds() > 0) all["encode"] = {newest_->encode_seconds(), 0, 1};
    return all;
}

void LiveRenderer::check() const {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
}

namespace {

constexpr int jpeg_quality = 85;

std::string text_of(const std::vector<std::uint8_t>& bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

const std::string& Picture::jpeg() const {
    std::call_once(jpeg_made_, [&] {
        const double began = wall_seconds();
        jpeg_ = text_of(encode_jpeg(image, jpeg_quality));
        encode_seconds_ = wall_seconds() - began;
    });
    return jpeg_;
}

const std::string& Picture::png() const {
    std::call_once(png_made_, [&] { png_ = text_of(encode_png(image)); });
    return png_;
}

}  // namespace whorl

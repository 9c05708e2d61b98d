#include "tools/live/screen.h"

#include <chrono>

#include "engine/core/parallel.h"
#include "render/gl/renderer.h"
#include "render/look/camera.h"
#include "tools/process/usage.h"

namespace whorl {
namespace {

bool same(const SurfaceOptions& a, const SurfaceOptions& b) {
    return a.voxel == b.voxel && a.radius == b.radius && a.iso == b.iso && a.smoothing == b.smoothing && a.distance == b.distance;
}

}  // namespace

Screen::Screen(int width, int height) : width_(width), height_(height) {
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

Screen::~Screen() {
    close();
    thread_.join();
}

void Screen::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
}

void Screen::show(Frame frame) {
    auto shared = std::make_shared<const Frame>(std::move(frame));
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || !recorder_ || (!waiting_ && !busy_); });
    waiting_ = std::move(shared);
    changed_.notify_all();
}

void Screen::look(PictureOptions how) {
    const std::lock_guard lock(mutex_);
    how_ = std::make_shared<const PictureOptions>(std::move(how));
    look_again_ = true;
    changed_.notify_all();
}

std::shared_ptr<const Picture> Screen::newest() const {
    const std::lock_guard lock(mutex_);
    return newest_;
}

std::shared_ptr<const Picture> Screen::after(std::uint64_t number, double seconds) const {
    std::unique_lock lock(mutex_);
    const auto newer = [&] { return newest_ && newest_->number > number; };
    changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return closed_ || newer(); });
    return !closed_ && newer() ? newest_ : nullptr;
}

void Screen::work() {
    std::optional<Renderer> renderer(std::in_place, width_, height_);
    {
        const std::lock_guard lock(mutex_);
        device_ = renderer->device();
    }
    for (;;) {
        std::shared_ptr<const Frame> frame;
        bool is_new = false;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] { return closed_ || (how_ && (waiting_ || (look_again_ && drawn_))); });
            if (closed_) return;
            is_new = waiting_ != nullptr;
            frame = is_new ? std::move(waiting_) : drawn_;
            waiting_.reset();
            look_again_ = false;
            busy_ = true;
        }
        draw(renderer, std::move(frame), is_new);
    }
}

void Screen::draw(std::optional<Renderer>& renderer, std::shared_ptr<const Frame> frame, bool is_new) {
    std::shared_ptr<const PictureOptions> how;
    {
        const std::lock_guard lock(mutex_);
        how = how_;
    }
    const double began = wall_seconds();
    if (is_new || !same(how->surface, surface_of_)) {
        surface_ = shows_field(how->look) ? Surface{} : build_surface(*frame, how->surface);
        surface_of_ = how->surface;
    } else if (surface_.mesh.triangle.empty() && !shows_field(how->look)) {
        surface_ = build_surface(*frame, how->surface);
    }
    const double surfaced = wall_seconds();
    const View view = view_at(how->camera, frame->time, frame->domain_min, frame->domain_max);
    Image image = renderer->draw(*frame, surface_, how->look, view);
    const double drawn = wall_seconds();

    std::unique_lock lock(mutex_);
    drawn_ = frame;
    newest_ = std::make_shared<const Picture>(++pictures_, frame->number, frame->time, std::move(image));
    times_["surface"] = {surfaced - began, 0, 1};
    times_["draw"] = {drawn - surfaced, 0, 1};
    changed_.notify_all();
    if (is_new && recorder_) recorder_->add(newest_->image);  // show() and stop_recording() wait meanwhile, which is meant
    busy_ = false;
    changed_.notify_all();
}

void Screen::record(const std::filesystem::path& folder, double fps) {
    auto recorder = std::make_unique<Recorder>(folder, width_, height_, fps);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || (!waiting_ && !busy_); });  // what was shown before is not recorded
    recorder_ = std::move(recorder);
}

std::optional<Recorded> Screen::stop_recording() {
    std::unique_ptr<Recorder> recorder;
    {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return closed_ || !recorder_ || (!waiting_ && !busy_); });
        recorder = std::move(recorder_);
        changed_.notify_all();
    }
    if (!recorder) return std::nullopt;
    return recorder->finish();
}

std::optional<int> Screen::recording() const {
    const std::lock_guard lock(mutex_);
    return recorder_ ? std::optional(recorder_->pictures()) : std::nullopt;
}

StageTimes Screen::times() const {
    const std::lock_guard lock(mutex_);
    StageTimes all = times_;
    if (newest_ && newest_->encode_seconds() > 0) all["encode"] = {newest_->encode_seconds(), 0, 1};
    return all;
}

std::string Screen::device() const {
    const std::lock_guard lock(mutex_);
    return device_;
}

void Screen::check() const {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
}

}  // namespace whorl

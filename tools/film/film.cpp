#include "tools/film/film.h"

#include <fmt/format.h>

#include "engine/core/errors.h"
#include "engine/core/parallel.h"
#include "engine/io/frame_file.h"
#include "engine/io/points.h"
#include "render/gl/renderer.h"
#include "render/surface/mesh_export.h"
#include "render/surface/vdb.h"
#include "render/video/encoder.h"
#include "tools/film/contact_sheet.h"
#include "tools/process/usage.h"

namespace whorl {
namespace {

std::filesystem::path numbered(const std::filesystem::path& folder, const char* kind, int frame, const char* extension) {
    return folder / kind / fmt::format("{:06}.{}", frame, extension);
}

}  // namespace

Film::Film(FilmOptions options) : options_(std::move(options)) {
    share_threads_with_software_driver();
    start("surface", &Film::make_surfaces);
    start("draw", &Film::draw);
    start("write", &Film::write);
}

Film::~Film() {
    for (Queue* queue : {&to_surface_, &to_draw_, &to_write_}) queue->abort();
    join();
}

void Film::start(const char* name, void (Film::*work)()) {
    threads_.emplace_back([this, name, work] {
        name_thread(name);
        adopt_threads();
        try {
            (this->*work)();
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!error_) error_ = std::current_exception();
            for (Queue* queue : {&to_surface_, &to_draw_, &to_write_}) queue->abort();
        }
    });
}

bool Film::exports(const char* what) const {
    return std::find(options_.exports.begin(), options_.exports.end(), what) != options_.exports.end();
}

void Film::timed(const char* stage, const std::function<void()>& work) {
    const double wall = wall_seconds();
    work();
    const auto cpu = cpu_by_thread_name();
    const std::lock_guard lock(mutex_);
    StageTime& spent = times_[stage];
    spent.wall += wall_seconds() - wall;
    if (const auto own = cpu.find(stage); own != cpu.end()) spent.cpu = own->second;
    ++spent.calls;
}

void Film::make_surfaces() {
    while (auto shot = to_surface_.pop()) {
        if ((options_.images && !shows_field((*shot)->how->look)) || exports("mesh"))
            timed("surface", [&] { (*shot)->surface = build_surface(*(*shot)->frame, (*shot)->how->surface); });
        if (!to_draw_.push(std::move(*shot))) return;
    }
    to_draw_.close();
}

void Film::draw() {
    std::optional<Renderer> renderer;  // made here, at once: the context belongs to this thread, and making it takes a while
    if (options_.images) renderer.emplace(options_.width, options_.height);
    while (auto shot = to_draw_.pop()) {
        const Frame& frame = *(*shot)->frame;
        if (renderer)
            timed("draw", [&] {
                const View view = view_at((*shot)->how->camera, frame.time, frame.domain_min, frame.domain_max);
                (*shot)->image = renderer->draw(frame, (*shot)->surface, (*shot)->how->look, view);
                const std::lock_guard lock(mutex_);
                device_ = renderer->device();
            });
        if (!to_write_.push(std::move(*shot))) return;
    }
    to_write_.close();
}

void Film::write() {
    std::optional<VideoEncoder> encoder;
    if (!options_.video.empty()) {
        encoder.emplace(options_.video, options_.width, options_.height, VideoOptions{options_.fps, 18});
        for (int frame = 1; frame <= options_.frames_before; ++frame) encoder->add(read_png(picture_file(options_.folder, frame)));
    }
    while (auto shot = to_write_.pop()) {
        timed("write", [&] {
            write_files(**shot);
            if (encoder) encoder->add((*shot)->image);
            if ((*shot)->write_state) write_checkpoint(options_.folder, *(*shot)->state);
        });
        if (options_.images && first_picture_ == 0) first_picture_ = wall_seconds();
        written_ = (*shot)->frame->number;
        const std::lock_guard lock(mutex_);
        newest_state_ = (*shot)->state;
    }
    bool complete = false;
    {
        const std::lock_guard lock(mutex_);
        complete = complete_ && !error_;
    }
    const double cpu = children_cpu_seconds(), wall = wall_seconds();
    if (encoder && complete) encoder->finish();
    encoder.reset();
    const std::lock_guard lock(mutex_);
    if (!options_.video.empty()) times_["encode"] = {wall_seconds() - wall, children_cpu_seconds() - cpu, 1};
}

void Film::write_files(const Shot& shot) {
    const Frame& frame = *shot.frame;
    if (options_.images) write_png(picture_file(options_.folder, frame.number), shot.image);
    if (exports("points")) write_points(numbered(options_.folder, "points", frame.number, "ply"), frame);
    if (exports("raw")) write_frame(frame_file(options_.folder, frame.number), frame);
    if (exports("mesh")) write_ply_mesh(numbered(options_.folder, "mesh", frame.number, "ply"), shot.surface.mesh);
    if (exports("vdb")) write_vdb(numbered(options_.folder, "vdb", frame.number, "vdb"), frame, shot.how->surface);
}

void Film::rethrow() const {
    const std::lock_guard lock(mutex_);
    if (error_) std::rethrow_exception(error_);
}

void Film::add(Frame frame, std::shared_ptr<const PictureOptions> how, std::shared_ptr<const Checkpoint> state, bool write_state) {
    auto shot = std::make_unique<Shot>();
    shot->frame = std::make_shared<const Frame>(std::move(frame));
    shot->how = std::move(how);
    shot->state = std::move(state);
    shot->write_state = write_state;
    if (!to_surface_.push(std::move(shot))) rethrow();
}

void Film::finish(bool complete) {
    {
        const std::lock_guard lock(mutex_);
        complete_ = complete;
    }
    to_surface_.close();
    join();
    rethrow();
}

void Film::join() {
    for (std::thread& thread : threads_)
        if (thread.joinable()) thread.join();
}

std::shared_ptr<const Checkpoint> Film::newest_state() const {
    const std::lock_guard lock(mutex_);
    return newest_state_;
}

StageTimes Film::times() const {
    const std::lock_guard lock(mutex_);
    return times_;
}

std::string Film::device() const {
    const std::lock_guard lock(mutex_);
    return device_;
}

}  // namespace whorl

#include "tools/film/film.h"

#include "engine/core/parallel.h"
#include "render/gl/renderer.h"
#include "render/surface/foam.h"
#include "render/video/encoder.h"
#include "tools/film/contact_sheet.h"

namespace whorl {
Film::Film(FilmOptions options) : options_(std::move(options)), exports_(options_) {
    share_threads_with_software_driver();
    try {
        start("surface", &Film::make_surfaces);
        start("draw", &Film::draw);
        start("export", &Film::export_files);
        start("write", &Film::write);
    } catch (...) {  // a thread could not be started
        stop();
        throw;
    }
}

Film::~Film() { stop(); }

void Film::stop() {
    for (Queue* queue : {&to_surface_, &to_draw_, &to_export_, &to_write_}) queue->abort();
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
            for (Queue* queue : {&to_surface_, &to_draw_, &to_export_, &to_write_}) queue->abort();
        }
    });
}

/// Does the work and adds its times to the stage. @param stage name of the calling thread, or that, a space and its task
void Film::timed(const std::string& stage, const std::function<void()>& work) {
    const std::string thread = stage.substr(0, stage.find(' '));
    const auto cpu_so_far = [&] {
        const auto cpu = cpu_by_thread_name();
        const auto own = cpu.find(thread);
        return own == cpu.end() ? 0.0 : own->second;
    };
    const double wall = wall_seconds(), cpu = cpu_so_far();
    work();
    const double cpu_now = cpu_so_far();
    const std::lock_guard lock(mutex_);
    StageTime& spent = times_[stage];
    spent.wall += wall_seconds() - wall;
    spent.cpu = thread == stage ? cpu_now : spent.cpu + cpu_now - cpu;  // all CPU time of a thread with one stage counts
    ++spent.calls;
}

void Film::make_surfaces() {
    while (auto shot = to_surface_.pop()) {
        const bool drawn = options_.output.images && !shows_field((*shot)->how->look);
        SurfaceOptions how = (*shot)->how->surface;
        how.distance = how.distance && (drawn || exports_.wants_distance());
        const bool wanted = drawn || (exports_.wants_surface() && (*shot)->frame->dimensions == 3);
        if (wanted) timed("surface", [&] { (*shot)->surface = build_surface(*(*shot)->frame, how, (*shot)->how->look.foam); });
        if (!to_draw_.push(std::move(*shot))) return;
    }
    to_draw_.close();
}

void Film::draw() {
    std::optional<Renderer> renderer;  // created on this thread, which owns the context, and early, because it takes a while
    if (options_.output.images) renderer.emplace(options_.output.size[0], options_.output.size[1]);
    while (auto shot = to_draw_.pop()) {
        const Frame& frame = *(*shot)->frame;
        if (renderer)
            timed("draw", [&] {
                const View view = view_at((*shot)->how->camera, frame.time, frame.domain_min, frame.domain_max);
                if (options_.output.format == "exr") {
                    const View next =
                        view_at((*shot)->how->camera, frame.time + options_.time.frame_interval(), frame.domain_min, frame.domain_max);
                    (*shot)->layers = renderer->draw_layers(frame, (*shot)->surface, (*shot)->how->look, view,
                                                            {next, static_cast<float>(options_.time.frame_interval())});
                } else (*shot)->image = renderer->draw(frame, (*shot)->surface, (*shot)->how->look, view);
                const std::lock_guard lock(mutex_);
                device_ = renderer->device();
            });
        if (!to_export_.push(std::move(*shot))) return;
    }
    to_export_.close();
}

void Film::export_files() {
    while (auto shot = to_export_.pop()) {
        exports_.write(*(*shot)->frame, (*shot)->surface, *(*shot)->how, (*shot)->write_state,
                       [&](const std::string& kind, const std::function<void()>& work) { timed("export " + kind, work); });
        if (!to_write_.push(std::move(*shot))) return;
    }
    exports_.finish();
    to_write_.close();
}

/// Writes the image and removes the frame's image in the other format.
void Film::write_picture(const Shot& shot) const {
    const bool exr = options_.output.format == "exr";
    const std::filesystem::path file = picture_file(options_.folder, shot.frame->number, options_.output.format);
    if (exr) write_exr(file, shot.layers, {options_.time.fps, shot.frame->time});
    else write_png(file, shot.image);
    std::filesystem::remove(picture_file(options_.folder, shot.frame->number, exr ? "png" : "exr"));
}

void Film::write() {
    std::optional<VideoEncoder> encoder;
    if (!options_.video().empty()) {
        encoder.emplace(options_.video(), options_.output.size[0], options_.output.size[1], VideoOptions{options_.time.fps, 18});
        for (int frame = 1; frame <= options_.frames_before; ++frame)
            encoder->add(read_picture(options_.folder, frame, options_.output.size[0], options_.output.size[1]));
    }
    while (auto shot = to_write_.pop()) {
        timed("write", [&] {
            if (options_.output.images) write_picture(**shot);
            if (encoder) encoder->add(options_.output.format == "exr" ? shown((*shot)->layers) : (*shot)->image);
            if ((*shot)->write_state) write_checkpoint(options_.folder, *(*shot)->state);
        });
        written_ = (*shot)->frame->number;
        const std::lock_guard lock(mutex_);
        newest_state_ = (*shot)->state;
    }
    const bool complete = locked(mutex_, complete_) && !locked(mutex_, error_);
    const double cpu = children_cpu_seconds(), wall = wall_seconds();
    if (encoder && complete) encoder->finish();
    encoder.reset();
    const std::lock_guard lock(mutex_);
    if (!options_.video().empty()) times_["encode"] = {wall_seconds() - wall, children_cpu_seconds() - cpu, 1};
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

}  // namespace whorl

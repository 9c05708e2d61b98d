#pragma once
/// From frames to pictures and files: surface -> draw -> export -> write, each on its own thread, with a bounded queue before each.
///
///   add(frame) --> [queue] --> surface --> [queue] --> draw --> [queue] --> export --> [queue] --> write: PNG, video, checkpoint
///
/// A full queue makes the caller of add() wait; nothing is dropped. A frame's checkpoint travels with it and is written after its picture
/// and exports, so a checkpoint never promises files that do not exist. What a stage throws stops all stages and comes out of add() or
/// finish().
#include <atomic>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "engine/core/clock.h"
#include "engine/io/checkpoint.h"
#include "engine/io/frame.h"
#include "render/image/exr.h"
#include "tools/film/bounded_queue.h"
#include "tools/film/exports.h"

namespace whorl {

class Film {
public:
    explicit Film(FilmOptions options);
    /// Stops without finishing; the unfinished video keeps its partial name.
    ~Film();
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    /// @param how to make its picture @param state of the run at the frame's time @param write_state also write it to disk
    /// @throws whatever a stage threw
    void add(Frame frame, std::shared_ptr<const PictureOptions> how, std::shared_ptr<const Checkpoint> state, bool write_state);
    /// Waits until all frames are written. @param complete false: the run continues later, the video keeps its partial name
    void finish(bool complete);

    /// The state of the last frame that is completely written; null before the first.
    std::shared_ptr<const Checkpoint> newest_state() const;
    int frames_written() const { return written_; }
    /// Wall and CPU seconds of surface, draw, export, write (threads that these start included) and encode (the encoder's process, once it
    /// has ended).
    StageTimes times() const;
    /// Renderer and version of the GL in use; "" before the first picture or without pictures.
    std::string device() const;

private:
    struct Shot {
        std::shared_ptr<const Frame> frame;
        std::shared_ptr<const PictureOptions> how;
        std::shared_ptr<const Checkpoint> state;
        bool write_state = false;
        Surface surface;
        Image image;           ///< of the format png
        PictureLayers layers;  ///< of the format exr
    };
    using Queue = BoundedQueue<std::unique_ptr<Shot>>;

    void start(const char* name, void (Film::*work)());
    void make_surfaces();
    void draw();
    void export_files();
    void write();
    void write_picture(const Shot& shot) const;
    void timed(const std::string& stage, const std::function<void()>& work);
    void stop();
    void join();
    void rethrow() const;

    FilmOptions options_;
    Exports exports_;  ///< the thread "export" has it
    Queue to_surface_{1}, to_draw_{1}, to_export_{1}, to_write_{1};
    std::vector<std::thread> threads_;
    mutable std::mutex mutex_;  ///< protects the members below
    std::exception_ptr error_;
    std::shared_ptr<const Checkpoint> newest_state_;
    StageTimes times_;
    std::string device_;
    bool complete_ = false;
    std::atomic<int> written_{0};
};

}  // namespace whorl

#pragma once
/// Pipeline from frames to images and files. Each stage has its own thread, with a bounded queue before it.
///
///   add(frame) --> [queue] --> surface --> [queue] --> draw --> [queue] --> export --> [queue] --> write: PNG, video, checkpoint
///
/// A full queue makes the caller of add() wait; no frame is dropped. A checkpoint passes through the queues with its frame and is written
/// after the frame's image and exports, so all files up to a checkpoint exist. An exception in a stage stops all stages; add() or finish()
/// rethrows it.
#include <atomic>
#include <exception>
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
#include "tools/process/process.h"

namespace whorl {

class Film {
public:
    explicit Film(FilmOptions options);
    /// Stops without finishing; the incomplete video keeps its name from partial_video().
    ~Film();
    Film(const Film&) = delete;
    Film& operator=(const Film&) = delete;

    /// Passes a frame to the pipeline. @param how options of its image @param state state of the run at the frame's time
    /// @param write_state also writes the state to disk @throws the exception of a stage
    void add(Frame frame, std::shared_ptr<const PictureOptions> how, std::shared_ptr<const Checkpoint> state, bool write_state);
    /// Waits until all frames are written. @param complete false if the run will be continued; the video then keeps its name from
    /// partial_video()
    void finish(bool complete);

    /// State of the run at the last frame whose files are all written; null before the first.
    std::shared_ptr<const Checkpoint> newest_state() const { return locked(mutex_, newest_state_); }
    int frames_written() const { return written_; }
    /// Wall and CPU time [s] of the stages surface, draw, export and write, with the threads that they start, and of encode (the encoder
    /// process, after it has ended).
    StageTimes times() const { return locked(mutex_, times_); }
    /// Renderer and version of OpenGL; "" before the first image or without images.
    std::string device() const { return locked(mutex_, device_); }

private:
    struct Shot {
        std::shared_ptr<const Frame> frame;
        std::shared_ptr<const PictureOptions> how;
        std::shared_ptr<const Checkpoint> state;
        bool write_state = false;
        Surface surface;
        Image image;           ///< if the format is png
        PictureLayers layers;  ///< if the format is exr
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
    Exports exports_;  ///< used by the thread "export"
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

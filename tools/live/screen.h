#pragma once
/// From frames to pictures, on a thread of its own: surface -> draw -> newest picture. A frame that comes before the last one was drawn
/// takes its place: stale frames are dropped, and the simulation never waits (but while pictures are recorded).
#include <condition_variable>
#include <exception>
#include <optional>
#include <thread>

#include "tools/film/film.h"
#include "tools/live/picture.h"
#include "tools/live/recorder.h"

namespace whorl {

class Screen {
public:
    Screen(int width, int height);
    ~Screen();
    Screen(const Screen&) = delete;
    Screen& operator=(const Screen&) = delete;

    void show(Frame frame);
    /// How pictures are made from now on; the newest frame is drawn again.
    void look(PictureOptions how);

    /// The newest picture; null before the first.
    std::shared_ptr<const Picture> newest() const;
    /// Waits for a picture newer than `number`. @return null where none came within `seconds`, or the screen was closed
    std::shared_ptr<const Picture> after(std::uint64_t number, double seconds) const;
    /// Ends after() for all who wait in it.
    void close();

    /// Writes each new frame's picture from now on. @throws EnvironmentError where the folder cannot be made
    void record(const std::filesystem::path& folder, double fps);
    /// @return what was recorded; nothing where nothing was
    std::optional<Recorded> stop_recording();
    /// Pictures recorded so far; nothing where none are.
    std::optional<int> recording() const;

    /// Wall seconds of the newest picture by stage: surface, draw.
    StageTimes times() const;
    std::string device() const;
    /// @throws what ended the thread, if anything did
    void check() const;

private:
    void work();
    void draw(std::optional<class Renderer>& renderer, std::shared_ptr<const Frame> frame, bool is_new);

    int width_, height_;
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    std::shared_ptr<const Frame> waiting_, drawn_;
    std::shared_ptr<const PictureOptions> how_;
    bool look_again_ = false, closed_ = false, busy_ = false;
    std::shared_ptr<const Picture> newest_;
    std::uint64_t pictures_ = 0;
    StageTimes times_;
    std::string device_;
    std::exception_ptr error_;
    std::unique_ptr<Recorder> recorder_;
    Surface surface_;  ///< of drawn_; the thread's own
    SurfaceOptions surface_of_;
    std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace whorl

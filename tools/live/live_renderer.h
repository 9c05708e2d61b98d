#pragma once
/// Makes images of states on its own thread: surface -> draw -> latest image. Each is of the latest state, at most one per frame interval;
/// earlier states are dropped, and the simulation never waits. A change of the look and the first state after a change of the fluid are
/// drawn immediately.
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "render/image/image.h"
#include "tools/film/film.h"

namespace whorl {

/// The newest change of the scene (Controls::revision) that a picture shows: of the fluid, and of how it is drawn.
struct Revisions {
    std::uint64_t fluid = 0, look = 0;
};

class Picture {
public:
    Picture(std::uint64_t its_number, int of_frame, double at_time, Revisions shown, Image its_image)
        : number(its_number), frame(of_frame), time(at_time), revisions(shown), image(std::move(its_image)) {}
    const std::uint64_t number;  ///< grows with every picture of this process
    const int frame;
    const double time;  ///< s, simulated
    const Revisions revisions;
    const Image image;
    const std::string& jpeg() const;
    const std::string& png() const;
    /// Wall seconds that the JPEG took; 0 if not requested.
    double encode_seconds() const { return encode_seconds_; }

private:
    mutable std::once_flag jpeg_made_, png_made_;
    mutable std::string jpeg_, png_;
    mutable std::atomic<double> encode_seconds_{0};
};

class LiveRenderer {
public:
    /// @param frame s, the film's frame interval as it plays
    LiveRenderer(int width, int height, double frame);
    ~LiveRenderer();
    LiveRenderer(const LiveRenderer&) = delete;
    LiveRenderer& operator=(const LiveRenderer&) = delete;

    /// @param revision of the scene that the simulation went by
    void show(Frame frame, std::uint64_t revision);
    /// Whether the next image is due within `seconds`, so that a state between two frames is of use.
    bool wants_state_within(double seconds) const;
    /// @param frame s, the film's frame interval as it plays
    void set_interval(double frame);
    /// Sets the look of images, that of the scene's `revision`; the latest frame is drawn again.
    void look(PictureOptions how, std::uint64_t revision);

    /// The newest picture; null before the first.
    std::shared_ptr<const Picture> newest() const;
    /// Waits for a picture newer than `number`. @return null if none came within `seconds`, or the screen was closed
    std::shared_ptr<const Picture> after(std::uint64_t number, double seconds) const;
    /// Ends after() for all who wait in it.
    void close();

    /// Wall seconds of the last image by stage: surface, draw.
    StageTimes times() const;
    std::string device() const;
    /// @throws the exception that ended the thread, if any
    void check() const;

private:
    struct State {
        Frame frame;
        std::uint64_t revision;
    };
    struct Look {
        PictureOptions how;
        std::uint64_t revision;
    };
    void work();
    std::shared_ptr<const State> next(bool& is_new);
    void draw(std::optional<class Renderer>& renderer, std::shared_ptr<const State> state, bool is_new);

    int width_, height_;
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
    std::shared_ptr<const State> waiting_, drawn_;
    std::shared_ptr<const Look> look_;
    bool closed_ = false;
    double interval_, due_ = 0;   ///< s, wall: least time between two images, of the next one
    std::uint64_t shown_ = 0;     ///< revision of the fluid in the latest image
    bool look_is_drawn_ = false;  ///< the latest image has the latest look
    std::shared_ptr<const Picture> newest_;
    std::uint64_t pictures_ = 0;
    StageTimes times_;
    std::string device_;
    std::exception_ptr error_;
    Surface surface_;  ///< of drawn_; the thread's own
    SurfaceOptions surface_of_;
    std::thread thread_;  ///< last: it uses all of the above
};

}  // namespace whorl

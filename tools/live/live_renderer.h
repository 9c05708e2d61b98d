#pragma once
/// Draws images of a live run on a separate thread: state -> surface -> image. It draws the latest state, at most one image per frame
/// interval, and drops earlier states; the simulation never waits. A change of the look and the first state after a change of the fluid are
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

/// Revisions of the scene (Controls::revision) that an image shows, separately for the simulation and for the look.
struct Revisions {
    std::uint64_t fluid = 0, look = 0;
};

/// Image of a live run, encoded when first requested. Thread-safe.
class Picture {
public:
    Picture(std::uint64_t its_number, int of_frame, double at_time, Revisions shown, Image its_image)
        : number(its_number), frame(of_frame), time(at_time), revisions(shown), image(std::move(its_image)) {}
    const std::uint64_t number;  ///< increases with every image of this process
    const int frame;
    const double time;  ///< s, simulated
    const Revisions revisions;
    const Image image;
    const std::string& jpeg() const;
    const std::string& png() const;
    /// Wall time of encoding the JPEG [s]; 0 if it was not requested.
    double encode_seconds() const { return encode_seconds_; }

private:
    mutable std::once_flag jpeg_made_, png_made_;
    mutable std::string jpeg_, png_;
    mutable std::atomic<double> encode_seconds_{0};
};

class LiveRenderer {
public:
    /// @param width,height pixels @param frame playing time of a frame [s]
    LiveRenderer(int width, int height, double frame);
    ~LiveRenderer();
    LiveRenderer(const LiveRenderer&) = delete;
    LiveRenderer& operator=(const LiveRenderer&) = delete;

    /// Sets the latest state. @param revision revision of the scene that the simulation used
    void show(Frame frame, std::uint64_t revision);
    /// Whether the next image is due within `seconds`. Then a state between two frames is useful.
    bool wants_state_within(double seconds) const;
    /// @param frame playing time of a frame [s]
    void set_interval(double frame);
    /// Sets the look and draws the latest frame again. An older `revision` of the scene than the current one is ignored.
    void look(PictureOptions how, std::uint64_t revision);

    /// Draws no state without this change of the scene for a moment, so that the image of the state with the change is not delayed.
    /// @param revision of a change that the simulation has not made yet
    void expect(std::uint64_t revision);

    /// Latest image; null before the first.
    std::shared_ptr<const Picture> newest() const { return locked(mutex_, newest_); }
    /// Waits for an image with a number above `number`. @return null if there is none within `seconds`, or after close()
    std::shared_ptr<const Picture> after(std::uint64_t number, double seconds) const;
    /// Ends the drawing thread and every waiting call of after().
    void close();

    /// Wall times of the last image by stage: surface, draw, and encode if a JPEG was requested.
    StageTimes times() const;
    /// Name of the GL device; empty until it is opened.
    std::string device() const { return locked(mutex_, device_); }
    /// Rethrows the exception that ended the drawing thread, if any.
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
    double interval_, due_ = 0;   ///< least interval between two images [s]; wall time when the next one is due [s]
    std::uint64_t shown_ = 0;     ///< revision of the simulation in the latest image
    std::uint64_t expected_ = 0;  ///< revision that expect() announced
    double expected_until_ = 0;   ///< wall time until which to wait for it [s]
    bool look_is_drawn_ = false;  ///< whether the latest image has the latest look
    std::shared_ptr<const Picture> newest_;
    std::uint64_t pictures_ = 0;
    StageTimes times_;
    std::string device_;
    std::exception_ptr error_;
    Surface surface_;            ///< surface of drawn_; used only by the drawing thread
    SurfaceOptions surface_of_;  ///< options of surface_
    std::thread thread_;         ///< declared last, because it uses all members above
};

}  // namespace whorl

#include "render/video/encoder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "engine/core/atomic_file.h"
#include "engine/core/errors.h"
#include "render/video/process.h"

namespace whorl {
namespace {

const char* const install = "apt-get install ffmpeg";
const char* const once_it_works = "once ffmpeg works, use whorl resume to continue a run, or whorl video to encode existing images";

ChildProcess start(const std::vector<std::string>& arguments) {
    try {
        return ChildProcess(arguments);
    } catch (const std::system_error& error) { throw EnvironmentError("no video: cannot start ffmpeg", error.what(), install); }
}

/// Exit code or signal of ffmpeg, and the last lines of its output if any. @param code result of wait()
std::string end_of(const ChildProcess& ffmpeg, int code) {
    const int signal = ffmpeg.ended_by();
    const std::string words = last_lines(ffmpeg.output());
    return (signal > 0 ? "ffmpeg was killed by signal " + std::to_string(signal) : "ffmpeg ended with code " + std::to_string(code)) +
           (words.empty() ? "" : ": " + words);
}

const char* const to_bt709 =
    "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,"
    "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:flags=bicubic+accurate_rnd+full_chroma_int+full_chroma_inp,";
const char* const tagged_bt709 = "-color_range tv -colorspace bt709 -color_primaries bt709 -color_trc bt709";

// Each frame should soon be in the file, in case all processes are killed: hence a short look-ahead, one keyframe per second, and fragments
// of a quarter of a second. One thread is enough, and the simulation needs the others: "veryfast" takes 10 ms for a frame of 1280x720
// ("medium" takes 24 ms and gains 0.7 dB at the same file size).
std::string mp4(const VideoOptions& options) {
    return fmt::format(
        "-vf {}format=yuv420p -c:v libx264 -preset veryfast -crf {} -threads 1 -g {} -x264-params rc-lookahead=8:sync-lookahead=0 {} "
        "-movflags +empty_moov+default_base_moof -frag_duration 250000 -flush_packets 1 -f mp4",
        to_bt709, options.crf, std::clamp(std::lround(options.fps), 1L, 250L), tagged_bt709);
}

/// ProRes 422 HQ, or 4444 with alpha, for video editors.
std::string mov(const VideoOptions& options) {
    // setparams tags the images, whose tags the encoder writes. The tags of the stream (tagged_bt709) reach only the container.
    return fmt::format(
        "-vf {}setparams=range=tv:colorspace=bt709:color_primaries=bt709:color_trc=bt709,format={} -c:v prores_ks -profile:v {} -threads 1 "
        "{} {} -f mov",
        to_bt709, options.alpha ? "yuva444p10le" : "yuv422p10le", options.alpha ? 4 : 3, options.alpha ? "-alpha_bits 16" : "",
        tagged_bt709);
}

/// VP9 needs a larger crf than H.264 for the same quality. libvpx supports alpha only without alternate reference frames.
std::string webm(const VideoOptions& options) {
    return fmt::format("-vf {}format={} -c:v libvpx-vp9 -b:v 0 -crf {} -deadline good -cpu-used 5 -threads 1 {} {} -f webm", to_bt709,
                       options.alpha ? "yuva420p" : "yuv420p", std::min(63, options.crf + 12), tagged_bt709,
                       options.alpha ? "-auto-alt-ref 0" : "");
}

/// One palette for the whole video, chosen for its moving parts. At most 25 frames per second: programs show no more.
std::string gif(const VideoOptions& options) {
    return fmt::format(
        "-vf fps={:f},split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=3 -loop 0 -f gif",
        std::min(25.0, options.fps));
}

struct Format {
    const char* suffix;
    std::string (*encode)(const VideoOptions&);
    bool has_alpha;
    const char* container;  ///< format of the rewrite that makes playback start fast; null: no rewrite
};
constexpr Format formats[] = {
    {".mp4", mp4, false, "mp4"}, {".mov", mov, true, "mov"}, {".webm", webm, true, nullptr}, {".gif", gif, false, nullptr}};

const Format& format_of(const std::filesystem::path& file) {
    const auto found = std::find_if(std::begin(formats), std::end(formats), [&](const Format& f) { return file.extension() == f.suffix; });
    WHORL_ASSERT(found != std::end(formats), +file.string());
    return *found;
}

/// Frames per second, as ffmpeg reads it. NTSC rates are exact fractions: 29.97 is 30000/1001, 23.98 is 24000/1001.
std::string rate(double fps) {
    const double whole = std::ceil(fps);
    return std::abs(whole / 1.001 - fps) < 2e-4 * fps ? fmt::format("{:.0f}/1001", 1000 * whole) : fmt::format("{}", fps);
}

/// @param file final name of the video
std::vector<std::string> encode_arguments(const std::filesystem::path& file, int width, int height, const VideoOptions& options) {
    std::vector<std::string> words = words_of(
        fmt::format("ffmpeg -nostdin -hide_banner -loglevel error -y -f rawvideo -pixel_format {} -video_size {}x{} -framerate {} -i "
                    "pipe:0 -filter_threads 1 {}",
                    options.alpha ? "rgba" : "rgb24", width, height, rate(options.fps), format_of(file).encode(options)));
    words.push_back(std::filesystem::absolute(partial_video(file)).string());  // absolute: 12:00.mp4 would have the protocol "12"
    return words;
}

std::vector<std::string> rewrite_arguments(const std::filesystem::path& from, const char* container, const std::filesystem::path& to) {
    std::vector<std::string> words = words_of("ffmpeg -nostdin -hide_banner -loglevel error -y -i");
    words.push_back(std::filesystem::absolute(from).string());
    for (const std::string& word : words_of(fmt::format("-c copy -movflags +faststart -f {}", container))) words.push_back(word);
    words.push_back(std::filesystem::absolute(to).string());
    return words;
}

}  // namespace

bool video_has_alpha(const std::filesystem::path& file) { return format_of(file).has_alpha; }

const std::vector<std::string>& video_suffixes() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> names;
        for (const Format& format : formats) names.emplace_back(format.suffix);
        return names;
    }();
    return all;
}

struct VideoEncoder::Process {
    std::filesystem::path file;
    int width, height;
    bool alpha;
    ChildProcess ffmpeg;
};

VideoEncoder::VideoEncoder(std::filesystem::path file, int width, int height, VideoOptions options) {
    options.alpha = options.alpha && video_has_alpha(file);
    ChildProcess ffmpeg = start(encode_arguments(file, width, height, options));
    process_ = std::make_unique<Process>(Process{std::move(file), width, height, options.alpha, std::move(ffmpeg)});
}

VideoEncoder::~VideoEncoder() = default;
VideoEncoder::VideoEncoder(VideoEncoder&&) noexcept = default;

void VideoEncoder::add(const Image& image) {
    WHORL_ASSERT(process_ != nullptr && image.width == process_->width && image.height == process_->height,
                 +std::to_string(image.width) + "x" + std::to_string(image.height));
    const bool plain = !process_->alpha && image.alpha.empty();
    if (process_->ffmpeg.write(plain ? image.rgb : process_->alpha ? with_alpha(image) : over_grey(image).rgb)) return;
    const int code = process_->ffmpeg.wait();
    throw EnvironmentError("the video encoder ended early: " + end_of(process_->ffmpeg, code), "", once_it_works);
}

void VideoEncoder::finish() {
    WHORL_ASSERT(process_ != nullptr);
    const std::unique_ptr<Process> process = std::move(process_);
    if (const int code = process->ffmpeg.wait(); code != 0)
        throw EnvironmentError("the video encoder failed: " + end_of(process->ffmpeg, code), "", once_it_works);
    const char* const container = format_of(process->file).container;
    if (container == nullptr) return std::filesystem::rename(partial_video(process->file), process->file);
    AtomicFile whole(process->file);
    ChildProcess rewrite = start(rewrite_arguments(partial_video(process->file), container, whole.temporary()));
    if (const int code = rewrite.wait(); code != 0)
        throw EnvironmentError("cannot rewrite the video: " + end_of(rewrite, code), "",
                               partial_video(process->file).string() + " is complete and playable");
    whole.commit();
    std::filesystem::remove(partial_video(process->file));
}

std::filesystem::path partial_video(const std::filesystem::path& file) {
    return file.parent_path() / ("." + file.filename().string() + ".partial");
}

std::string check_encoder(const std::string& way_out) {
    const auto refuse = [&](const std::string& why, const std::string& remedy) {
        throw EnvironmentError("no video: cannot start ffmpeg: " + why, "", remedy + (way_out.empty() ? "" : ", " + way_out));
    };
    std::string text;
    try {
        ChildProcess ffmpeg({"ffmpeg", "-version"});
        if (const int code = ffmpeg.wait(); code != 0) refuse(end_of(ffmpeg, code), "repair ffmpeg");
        text = ffmpeg.output();
    } catch (const std::system_error& error) { refuse(error.what(), install); }
    return text.substr(0, text.find('\n'));
}

std::string encoder_version() {
    try {
        return check_encoder();
    } catch (const EnvironmentError&) { return ""; }
}

}  // namespace whorl

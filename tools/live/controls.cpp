#include "tools/live/controls.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "engine/core/atomic_file.h"
#include "engine/core/clock.h"
#include "engine/io/csv.h"
#include "engine/probes/comparison.h"
#include "tools/cost/choices.h"
#include "tools/process/process.h"

namespace whorl {
namespace {

/// Longest interval between two changes of the same keys that count as one movement of a slider, which undo reverts as a whole [s].
constexpr double one_movement = 1.0;
constexpr std::size_t kept_undos = 200;

/// Whether a change can be shown by drawing the same state again.
bool of_picture(const KeyDifference& d) {
    return d.path.starts_with("look") || d.path.starts_with("camera") || d.path.starts_with("surface");
}

SceneFile without_later_changes(SceneFile file) {
    file.scene.changes.clear();
    return file;
}

}  // namespace

Controls::Controls(Options options) : options_(std::move(options)) {
    orders_.playing = true;
    restart({});
}

void Controls::set(const std::vector<KeyValue>& changes) {
    const std::lock_guard lock(mutex_);
    set_locked(changes, true);
}

void Controls::set_locked(const std::vector<KeyValue>& changes, bool may_undo) {
    if (changes.empty()) return;
    auto next = std::make_shared<PlannedScene>();
    next->file = changed(wanted_, changes);
    const std::vector<KeyDifference> now_different = differences(wanted_, next->file);
    if (const auto lines = needs_restart(now_different); !lines.empty()) {
        std::vector<Problem> problems;
        for (const std::string& line : lines)
            problems.push_back({changes.front().value.place, line + " during the run",
                                "restart with it: POST /control {\"do\": \"restart\", \"set\": {...}}", ""});
        throw InputError(std::move(problems));
    }
    const bool simulates = decides(wanted_, next->file);
    next->plan = simulates ? make_plan(next->file.scene) : plan_;
    if (const auto models = changes_of_models(plan_, next->plan); !models.empty())
        throw InputError(changes.front().value.place, "the change needs other models: " + models.front().text(),
                         "restart with it: POST /control {\"do\": \"restart\", \"set\": {...}}");

    if (orders_.scene && orders_.scene->simulation) {  // a restart that has not begun yet: it begins with these values
        next->simulation = std::make_unique<Simulation>(next->file.scene, next->plan);
        check_probes(*next->simulation);
        orders_.changes.clear();
    } else {
        orders_.changes.insert(orders_.changes.end(), changes.begin(), changes.end());
    }
    if (may_undo) remember(differences(next->file, wanted_));
    wanted_ = next->file;
    plan_ = next->plan;
    orders_.scene = std::move(next);
    for (const KeyValue& c : changes) set_.insert_or_assign(c.path, c.value);
    ++revision_;
    if (simulates) simulated_revision_ = revision_;
    if (std::any_of(now_different.begin(), now_different.end(), of_picture)) picture_revision_ = revision_;
    changed_.notify_all();
}

/// Adds an undo. @param back changes from the new scene to the previous one
void Controls::remember(const std::vector<KeyDifference>& back) {
    Undo undo{{}, wall_seconds()};
    for (const KeyDifference& d : back)
        if (d.before && d.now) undo.back.push_back({d.path, *d.now});
    if (undo.back.empty()) return;
    const auto same_keys = [&](const Undo& before) {
        return std::equal(before.back.begin(), before.back.end(), undo.back.begin(), undo.back.end(),
                          [](const auto& a, const auto& b) { return a.path == b.path; });
    };
    if (!undo_.empty() && undo.when - undo_.back().when < one_movement && same_keys(undo_.back())) undo_.back().when = undo.when;
    else undo_.push_back(std::move(undo));
    if (undo_.size() > kept_undos) undo_.erase(undo_.begin());
}

bool Controls::undo() {
    const std::lock_guard lock(mutex_);
    if (undo_.empty()) return false;
    const Undo last = std::move(undo_.back());
    undo_.pop_back();
    set_locked(last.back, false);
    return true;
}

void Controls::restart(const Restart& how) {
    while (!try_restart(how)) {}
}

/// Places the particles without the lock, because that may take long. @return false if the scene was changed meanwhile; then try again
bool Controls::try_restart(const Restart& how) {
    std::unique_lock lock(mutex_);
    Options options = options_;
    const std::map<std::string, Value> set = set_;
    const std::uint64_t revision = revision_;
    lock.unlock();

    const bool other = !how.scene.empty();
    if (other) options.scene = how.scene, options.set.clear();
    if (!how.quality.empty()) options.quality = how.quality;
    const SceneFile base = without_later_changes(read_scene_file(options));
    std::map<std::string, Value> kept;
    std::string not_kept;
    auto next = std::make_shared<PlannedScene>();
    next->file = base;
    if (!other && !how.forget)
        for (const auto& [path, value] : set) try {
                next->file = changed(next->file, {{path, value}});
                kept.emplace(path, value);
            } catch (const InputError& error) {
                not_kept += (not_kept.empty() ? "values not kept by the restart: " : "; ") + std::string(error.what());
            }
    if (!how.set.empty()) next->file = changed(next->file, how.set);
    for (const KeyValue& c : how.set) kept.insert_or_assign(c.path, c.value);
    next->plan = make_plan(next->file);
    next->simulation = std::make_unique<Simulation>(next->file.scene, next->plan);
    check_probes(*next->simulation);
    if (wants_extent(next->file)) look_at(next->file.camera, foreseen_extent(*next->simulation));

    lock.lock();
    if (revision != revision_) return false;
    options_ = std::move(options);
    path_ = find_scene(options_.scene);
    from_file_ = base;
    set_ = std::move(kept);
    undo_.clear();
    wanted_ = next->file;
    plan_ = next->plan;
    orders_.scene = std::move(next);
    orders_.changes.clear();
    file_problem_.clear();
    if (!not_kept.empty()) tell_locked(false, not_kept);
    picture_revision_ = simulated_revision_ = ++revision_;
    changed_.notify_all();
    return true;
}

void Controls::file_edited() {
    const std::lock_guard lock(mutex_);
    try {
        SceneFile now = without_later_changes(read_scene_file(options_));
        file_problem_.clear();
        std::vector<KeyValue> live;        // changes that are possible during the run
        std::vector<std::string> restart;  // keys whose changes need a restart
        for (const KeyDifference& d : differences(from_file_, now)) {
            const bool of_list = d.path.find('[') != std::string::npos;
            if (!d.now && !of_list) continue;
            if (d.now && d.key->may_change && (d.before || !of_list)) live.push_back({d.path, placed(*d.now, now.scene.place(d.path))});
            else restart.push_back(d.path);
        }
        set_locked(live, true);
        from_file_ = std::move(now);
        std::string text = live.empty() && restart.empty() ? "the scene file was saved; no value changed" : "the scene file was saved";
        for (std::size_t i = 0; i < live.size(); ++i) text += (i == 0 ? ": " : ", ") + live[i].path + " = " + live[i].value.toml();
        for (std::size_t i = 0; i < restart.size(); ++i) text += (i == 0 ? "; restart to use the new " : ", ") + restart[i];
        tell_locked(false, text);
    } catch (const std::exception& error) { tell_locked(true, file_problem_ = error.what()); }
}

void Controls::tell_locked(bool error, std::string text) { notice_ = Notice{++notices_, error, std::move(text)}; }

Orders Controls::take(double seconds) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(seconds),
                      [&] { return (orders_.playing && !waiting_) || orders_.step || orders_.scene; });
    Orders taken = take_changes_locked();
    taken.step = std::exchange(orders_.step, false);
    return taken;
}

Orders Controls::take_changes_locked() {
    Orders taken = orders_;
    taken.playing = orders_.playing && !waiting_;
    taken.step = false;
    taken.revision = revision_;
    taken.picture_revision = picture_revision_;
    orders_.scene.reset();
    orders_.changes.clear();
    return taken;
}

Orders Controls::take_changes() {
    const std::lock_guard lock(mutex_);
    if (!orders_.scene || orders_.scene->simulation) return {};
    return take_changes_locked();
}

void Controls::wait_for_change(double seconds) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return !orders_.playing || orders_.scene; });
}

namespace {

std::map<std::string, std::string> texts_by_key(const SceneFile& file) {
    std::map<std::string, std::string> all;
    for (const UsedKey& k : used_keys(file)) all[k.path] = k.value.toml();
    return all;
}

/// Whether the scene names files. Their paths are relative to the scene's folder, so a recording in another folder needs absolute paths.
bool names_files(const SceneFile& scene, const std::map<std::string, std::string>& values) {
    return !scene.look.environment.empty() || std::any_of(values.begin(), values.end(), [](const auto& value) {
        const bool optional = value.first.ends_with(".animation") || value.first.ends_with(".texture");
        return value.first.ends_with(".file") || (optional && value.second != "\"\"");
    });
}

}  // namespace

void ChangeRecording::begin(const SceneFile& scene, const std::filesystem::path& path, const std::string& quality) {
    quality_ = quality;
    name_ = scene.scene.name;
    entries_.clear();
    Options options;
    options.scene = path.string();
    options.quality = quality;
    const auto wanted = texts_by_key(scene);
    try {
        const SceneFile plain = read_scene_file(options);
        const auto given = texts_by_key(plain);
        base_ = read_whole(path);
        if (base_.rfind("\xEF\xBB\xBF", 0) == 0) base_.erase(0, 3);  // a byte order mark, which is only valid at the start of a file
        bool same_keys = !names_files(scene, wanted) && plain.scene.changes.empty() &&
                         plain.scene.blocks.size() == scene.scene.blocks.size() &&
                         plain.scene.emitters.size() == scene.scene.emitters.size() &&
                         plain.scene.solids.size() == scene.scene.solids.size() && plain.scene.lights.size() == scene.scene.lights.size() &&
                         plain.scene.probes.size() == scene.scene.probes.size() && plain.camera.keys.size() == scene.camera.keys.size();
        for (const auto& [key, value] : wanted) {
            const auto it = given.find(key);
            if (it == given.end() || it->second != value) entries_.push_back({0, key, value});
        }
        if (same_keys) return;
    } catch (const InputError&) {  // the file was edited since, and is invalid
    }
    entries_.clear();
    SceneFile alone = scene;
    alone.scene.changes.clear();
    base_ = resolved_toml(alone);
}

void ChangeRecording::add(double time, const std::vector<KeyValue>& changes) {
    for (const KeyValue& c : changes) {
        // If a key is changed several times at the same simulated time (a moving slider), only its last value counts.
        std::erase_if(entries_, [&](const Entry& e) { return e.time == time && e.key == c.path; });
        entries_.push_back({time, c.path, c.value.toml()});
    }
}

std::string ChangeRecording::text(double time) const {
    std::string text =
        fmt::format("# Recorded by whorl live with --quality {0}. To repeat it: whorl render recording.toml --quality {0}\n", quality_) +
        base_;
    if (!text.empty() && text.back() != '\n') text += '\n';
    const auto entry = [&](double when, const std::string& key, const std::string& value) {
        text += "\n[[change]]\ntime = " + Value(when).toml() + "\nkey = " + Value(key).toml() + "\nvalue = " + value + "\n";
    };
    for (const Entry& e : entries_)
        if (e.key != "time.end" && e.key != "name") entry(e.time, e.key, e.value);
    if (time > 0) entry(0, "time.end", Value(time).toml());
    entry(0, "name", Value(name_ + "_recording").toml());  // so that its run does not replace the scene's
    return text;
}

void ChangeRecording::write(double time) const { write_text(file(), text(time)); }

namespace {

/// Inode, size and time of the last change of a file, which differ after every save; zeros if the file does not exist (an editor may be
/// replacing it).
std::array<long, 4> stamp(const std::filesystem::path& file) {
    struct stat s {};
    if (stat(file.c_str(), &s) != 0) return {};
    return {static_cast<long>(s.st_ino), static_cast<long>(s.st_size), s.st_mtim.tv_sec, s.st_mtim.tv_nsec};
}

}  // namespace

std::jthread watch_file(std::function<std::filesystem::path()> file, std::function<void()> saved) {
    return std::jthread([file = std::move(file), saved = std::move(saved)](const std::stop_token& ending) {
        name_thread("watch");
        std::filesystem::path watched = file();
        auto known = stamp(watched), last = known;
        while (!ending.stop_requested()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(125));
            if (const auto now = file(); now != watched) watched = now, known = last = stamp(now);
            const auto seen = stamp(watched);
            const bool settled = seen == last && seen != decltype(seen){};
            last = seen;
            if (!settled || seen == known) continue;
            known = seen;
            saved();
        }
    });
}

}  // namespace whorl

#include "tools/live/journal.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "engine/core/whole_file.h"
#include "engine/io/files.h"

namespace whorl {
namespace {

std::map<std::string, std::string> texts_by_key(const SceneFile& file) {
    std::map<std::string, std::string> all;
    for (const UsedKey& k : used_keys(file)) all[k.path] = k.value().toml();
    return all;
}

/// Files are found from the scene's folder, and the recording lies in another one: it needs their whole paths.
bool names_files(const SceneFile& scene, const std::map<std::string, std::string>& values) {
    return !scene.look.environment.empty() ||
           std::any_of(values.begin(), values.end(), [](const auto& value) { return value.first.ends_with(".file"); });
}

}  // namespace

void Journal::begin(const SceneFile& scene, const std::filesystem::path& path, const std::string& quality) {
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
        if (base_.rfind("\xEF\xBB\xBF", 0) == 0) base_.erase(0, 3);  // a byte order mark, which may stand nowhere but at the start
        bool same_keys =
            !names_files(scene, wanted) && plain.scene.changes.empty() && plain.scene.blocks.size() == scene.scene.blocks.size() &&
            plain.scene.emitters.size() == scene.scene.emitters.size() && plain.scene.solids.size() == scene.scene.solids.size() &&
            plain.scene.probes.size() == scene.scene.probes.size() && plain.camera.keys.size() == scene.camera.keys.size();
        for (const auto& [key, value] : wanted) {
            const auto it = given.find(key);
            if (it == given.end() || it->second != value) entries_.push_back({0, key, value});
        }
        if (same_keys) return;
    } catch (const InputError&) {  // edited since, and broken
    }
    entries_.clear();
    SceneFile alone = scene;
    alone.scene.changes.clear();
    base_ = resolved_toml(alone);
}

void Journal::add(double time, const std::vector<KeyChange>& changes) {
    for (const KeyChange& c : changes) {
        // A slider that moved several times within a frame counts with its last value.
        std::erase_if(entries_, [&](const Entry& e) { return e.time == time && e.key == c.path; });
        entries_.push_back({time, c.path, c.value.toml()});
    }
}

std::string Journal::text(double time) const {
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
    entry(0, "name", Value(name_ + "_recording").toml());  // beside a film of the scene itself, not over it
    return text;
}

void Journal::write(double time) const { write_text(file(), text(time)); }

}  // namespace whorl

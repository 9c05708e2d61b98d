#include "tools/scene_file/scene_changes.h"

#include <algorithm>
#include <filesystem>

#include "engine/scene/read.h"
#include "engine/scene/tree.h"
#include "render/look/look_options.h"

namespace whorl {
namespace {

/// A key by its path, even if it has no effect now ("camera.position" before camera.kind = "fixed").
struct Found {
    const Key* key = nullptr;
    void* object = nullptr;
};
Found find(const Described& here, const std::string& path, const std::string& wanted) {
    for (const Key& key : here.table->keys)
        if (joined_path(path, key.name) == wanted) return {&key, const_cast<void*>(here.object)};
    Found found;
    each_part(here, path, [&](const KeyTable::Part&, const std::string& name, const Described& inner) {
        if (found.key == nullptr && wanted.rfind(name + ".", 0) == 0) found = find(inner, name, wanted);
    });
    return found;
}

std::vector<std::pair<std::string, Described>> roots(const SceneFile& file) {
    return {{"", {&scene_keys(), &file.scene}},
            {"surface", {&surface_keys(), &file.surface}},
            {"camera", {&camera_keys(), &file.camera}},
            {"look", {&look_keys(), &file.look}}};
}

Found find(const SceneFile& file, const std::string& path) {
    for (const auto& [name, root] : roots(file)) {
        const Found found = find(root, name, path);
        if (found.key != nullptr && path.rfind("change[", 0) != 0) return found;
    }
    return {};
}

Problem unknown(const SceneFile& file, const KeyValue& change) {
    std::vector<std::string> names;
    for (const UsedKey& k : used_keys(file)) names.push_back(k.path);
    const std::string near = nearest_name(change.path, names);
    return {change.value.place, "unknown key \"" + change.path + "\"", near.empty() ? "" : "did you mean \"" + near + "\"?", ""};
}

}  // namespace

std::vector<UsedKey> used_keys(const SceneFile& file) {
    std::vector<UsedKey> all;
    const auto sections = roots(file);
    for (const auto& [name, section] : sections) add_used_keys(section, sections.front().second, name, all);
    std::erase_if(all, [](const UsedKey& k) { return k.path.rfind("change[", 0) == 0; });
    return all;
}

std::vector<KeyDifference> differences(const SceneFile& before, const SceneFile& now) {
    return differences(used_keys(before), used_keys(now));
}

SceneFile changed(const SceneFile& file, const std::vector<KeyValue>& changes) {
    SceneFile copy = file;
    std::vector<Problem> problems;
    for (const KeyValue& change : changes) {
        const KeyValue c{full_path(change.path), change.value};
        const Found found = find(copy, c.path);
        if (found.key == nullptr) {
            problems.push_back(unknown(copy, c));
            continue;
        }
        const bool plane = copy.scene.domain.dimensions == 2;
        found.key->read(found.object, plane ? found.key->with_depth(c.value) : c.value, c.path, problems);
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    try {
        // Reading it again checks its consistency, and creates separate expressions.
        SceneFile fresh = read_resolved(resolved_toml(copy), std::filesystem::path(file.scene.directory) / "scene.toml");
        fresh.scene.directory = file.scene.directory;
        for (auto& [key, place] : fresh.scene.places) place = file.scene.place(key);  // not in the resolved text
        for (const KeyValue& change : changes) fresh.scene.places[full_path(change.path)] = change.value.place;
        if (fresh.look.environment != file.look.environment) find_environment(fresh);
        return fresh;
    } catch (const InputError& error) {
        for (Problem problem : error.problems()) {
            problem.place = changes.empty() ? FileLocation{} : changes.back().value.place;
            problems.push_back(std::move(problem));
        }
        throw InputError(std::move(problems));
    }
}

std::vector<std::string> needs_restart(const std::vector<KeyDifference>& differences) {
    std::vector<std::string> lines;
    for (const KeyDifference& d : differences) {
        if (d.key->may_change || d.path.rfind("output.", 0) == 0 || d.path.rfind("probe[", 0) == 0 || d.path == "name") continue;
        if (!d.before) lines.push_back(d.path + " is new");
        else if (!d.now) lines.push_back(d.path + " was removed");
        else lines.push_back(d.path + " cannot change from " + d.before->toml() + " to " + d.now->toml());
    }
    return lines;
}

std::vector<Appearance> looks_of_solids(const Scene& scene) {
    std::vector<Appearance> all;
    for (const SolidKeys& s : scene.solids) all.push_back(s.appearance);
    for (const EmitterKeys& e : scene.emitters) all.push_back(e.appearance);
    return all;
}

bool decides(const SceneFile& before, const SceneFile& now) {
    return !differences(before.scene, now.scene).empty() || before.scene.time.end != now.scene.time.end ||
           looks_of_solids(before.scene) != looks_of_solids(now.scene);
}

SceneFile with_first_changes(const SceneFile& file, const std::vector<KeyValue>& beat) {
    std::vector<KeyValue> first;
    std::vector<TimedChange> later;
    for (const TimedChange& c : file.scene.changes) {
        if (c.time <= 0) first.push_back(c.change);
        else later.push_back(c);
    }
    if (first.empty()) return file;
    SceneFile rest = file;
    rest.scene.changes.clear();
    first.insert(first.end(), beat.begin(), beat.end());
    SceneFile made = changed(rest, first);
    made.scene.changes = std::move(later);
    made.scene.places = file.scene.places;
    return made;
}

Replay::Replay(const SceneFile& file) : now_(file), changes_(file.scene.changes) {
    now_.scene.changes.clear();
    if (changes_.empty()) return;
    std::stable_sort(changes_.begin(), changes_.end(), [](const TimedChange& a, const TimedChange& b) { return a.time < b.time; });
    Replay trial(*this);
    Plan plan = make_plan(now_.scene);
    trial.apply_until(std::numeric_limits<double>::infinity(), [&](const Scene&, const Plan& next, double) {
        if (const auto models = changes_of_models(plan, next); !models.empty())
            throw InputError(trial.changes_[trial.made_ - 1].change.value.place,
                             "this change needs other models during the run: " + models[0].text(),
                             "set " + models[0].path + " in the scene, to a value for the whole run");
    });
}

double Replay::next() const { return made_ < changes_.size() ? changes_[made_].time : std::numeric_limits<double>::infinity(); }

bool Replay::apply_until(double time, const Follow& simulation) {
    bool any = false;
    while (made_ < changes_.size() && next() <= time) {
        const double when = next();
        std::vector<KeyValue> moment;
        for (; made_ < changes_.size() && changes_[made_].time == when; ++made_) moment.push_back(changes_[made_].change);
        SceneFile then = changed(now_, moment);
        if (const auto lines = needs_restart(differences(now_, then)); !lines.empty())
            throw InputError(moment.back().value.place, lines[0] + " during the run", "",
                             "allowed: keys that may change (whorl live --help)");
        const bool physics = decides(now_, then);
        now_ = std::move(then);
        if (physics) simulation(now_.scene, make_plan(now_.scene), when);
        any = true;
    }
    return any;
}

}  // namespace whorl

#include "tools/scene_file/scene_changes.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "engine/scene/read.h"
#include "engine/scene/scene_difference.h"
#include "engine/scene/tree.h"
#include "render/look/look_options.h"
#include "render/surface/surface_keys.h"

namespace whorl {
namespace {

/// The key of that name, also one that does not count now ("camera.position" before camera.kind = "fixed").
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

Problem unknown(const SceneFile& file, const KeyChange& change) {
    std::vector<std::string> names;
    for (const UsedKey& k : used_keys(file)) names.push_back(k.path);
    const std::string near = nearest_name(change.path, names);
    return {change.source, "unknown key \"" + change.path + "\"", near.empty() ? "" : "did you mean \"" + near + "\"?", ""};
}

void set_place(Value& v, const Place& place) {
    v.place = v.key_place = place;
    if (auto* list = v.as<Value::List>())
        for (Value& child : *list) set_place(child, place);
}

}  // namespace

std::string full_path(const std::string& path) {
    std::string out;
    for (std::size_t i = 0; i < path.size();) {
        std::size_t end = i + 1;
        while (end < path.size() && std::isdigit(static_cast<unsigned char>(path[end]))) ++end;
        if (path[i] == '.' && end > i + 1 && (end == path.size() || path[end] == '.')) {
            out += "[" + path.substr(i + 1, end - i - 1) + "]";
            i = end;
        } else {
            out += path[i++];
        }
    }
    return out;
}

KeyChange read_change(const Change& change) {
    std::vector<Problem> problems;
    Value tree{Value::Table{}};
    apply_change(tree, {"value", change.value, change.source, change.complete}, problems);
    if (!problems.empty()) throw InputError(std::move(problems));
    return {change.key, *tree.find("value"), {change.source, 0, 0}};
}

std::vector<UsedKey> used_keys(const SceneFile& file) {
    std::vector<UsedKey> all;
    const auto sections = roots(file);
    for (const auto& [name, section] : sections) add_used_keys(section, sections.front().second, name, all);
    std::erase_if(all, [](const UsedKey& k) { return k.path.rfind("change[", 0) == 0; });
    return all;
}

std::vector<KeyDifference> differences(const SceneFile& before, const SceneFile& now) {
    std::map<std::string, UsedKey> keys;
    const auto texts = [&](const SceneFile& file) {
        NamedTexts all;
        for (const UsedKey& k : used_keys(file)) {
            all.emplace_back(k.path, k.value().toml());
            keys.insert_or_assign(k.path, k);  // the later scene's, where both have it
        }
        return all;
    };
    const NamedTexts old = texts(before), fresh = texts(now);
    std::vector<KeyDifference> found;
    for (const Difference& d : differences(old, fresh)) found.push_back({d, keys.at(d.name).key, keys.at(d.name).value()});
    return found;
}

SceneFile changed(const SceneFile& file, const std::vector<KeyChange>& changes) {
    SceneFile copy = file;
    std::vector<Problem> problems;
    for (const KeyChange& change : changes) {
        KeyChange c{full_path(change.path), change.value, change.source};
        const Found found = find(copy, c.path);
        if (found.key == nullptr) {
            problems.push_back(unknown(copy, c));
            continue;
        }
        set_place(c.value, c.source);
        const bool plane = copy.scene.domain.dimensions == 2;
        found.key->read(found.object, plane ? found.key->with_depth(c.value) : c.value, c.path, problems);
    }
    if (!problems.empty()) throw InputError(std::move(problems));
    try {
        // Reading it again checks its consistency, and creates separate expressions.
        SceneFile fresh = read_resolved(resolved_toml(copy), std::filesystem::path(file.scene.directory) / "scene.toml");
        fresh.scene.directory = file.scene.directory;
        for (auto& [key, place] : fresh.scene.places) place = file.scene.place(key);  // the text above is no file
        for (const KeyChange& change : changes) fresh.scene.places[full_path(change.path)] = change.source;
        if (fresh.look.environment != file.look.environment) find_environment(fresh);
        return fresh;
    } catch (const InputError& error) {
        for (Problem problem : error.problems()) {
            problem.place = changes.empty() ? Place{} : changes.back().source;
            problems.push_back(std::move(problem));
        }
        throw InputError(std::move(problems));
    }
}

std::vector<std::string> needs_restart(const std::vector<KeyDifference>& differences) {
    std::vector<std::string> lines;
    for (const KeyDifference& d : differences) {
        if (d.key->may_change || d.name.rfind("output.", 0) == 0 || d.name.rfind("probe[", 0) == 0 || d.name == "name") continue;
        if (!d.before) lines.push_back(d.name + " is new");
        else if (!d.now) lines.push_back(d.name + " was removed");
        else lines.push_back(d.name + " cannot change from " + *d.before + " to " + *d.now);
    }
    return lines;
}

bool decides(const SceneFile& before, const SceneFile& now) {
    const auto material = [](const Scene& scene) {
        std::string all;
        for (const SolidKeys& s : scene.solids) all += s.material + "\n";
        return all;
    };
    return !differences(before.scene, now.scene).empty() || before.scene.time.end != now.scene.time.end ||
           material(before.scene) != material(now.scene);
}

SceneFile with_first_changes(const SceneFile& file, const std::vector<KeyChange>& beat) {
    std::vector<KeyChange> first;
    SceneFile rest = file;
    rest.scene.changes.clear();
    for (std::size_t i = 0; i < file.scene.changes.size(); ++i) {
        const ChangeKeys& c = file.scene.changes[i];
        if (c.time <= 0) first.push_back({c.key, c.value, file.scene.place("change[" + std::to_string(i) + "].value")});
        else rest.scene.changes.push_back(c);
    }
    if (first.empty()) return file;
    std::vector<ChangeKeys> later = std::move(rest.scene.changes);
    rest.scene.changes.clear();
    first.insert(first.end(), beat.begin(), beat.end());
    SceneFile made = changed(rest, first);
    made.scene.changes = std::move(later);
    made.scene.places = file.scene.places;
    for (std::size_t i = 0, k = 0; i < file.scene.changes.size(); ++i)
        if (file.scene.changes[i].time > 0)
            made.scene.places[entry_name("change", k++) + ".value"] = file.scene.place(entry_name("change", i) + ".value");
    return made;
}

Replay::Replay(const SceneFile& file) : now_(file), changes_(file.scene.changes) {
    for (std::size_t i = 0; i < changes_.size(); ++i) places_.push_back(file.scene.place(entry_name("change", i) + ".value"));
    now_.scene.changes.clear();
    if (changes_.empty()) return;
    std::vector<std::size_t> order(changes_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return changes_[a].time < changes_[b].time; });
    const auto changes = changes_;
    const auto places = places_;
    for (std::size_t i = 0; i < order.size(); ++i) changes_[i] = changes[order[i]], places_[i] = places[order[i]];

    Replay trial(*this);
    Plan plan = make_plan(now_.scene);
    trial.apply_until(std::numeric_limits<double>::infinity(), [&](const Scene&, const Plan& next, double) {
        const auto models = changes_of_models(plan, next);
        if (!models.empty())
            throw InputError(trial.places_[trial.made_ - 1], "this change needs other models during the run: " + models[0],
                             "set " + models[0].substr(0, models[0].find(':')) + " in the scene, to what suits the whole run");
    });
}

double Replay::next() const { return made_ < changes_.size() ? changes_[made_].time : std::numeric_limits<double>::infinity(); }

/// The scene after all changes of the next moment. @param change after the last of them
SceneFile Replay::moment(std::size_t& change) const {
    std::vector<KeyChange> made;
    const double time = changes_[change].time;
    for (; change < changes_.size() && changes_[change].time == time; ++change)
        made.push_back({changes_[change].key, changes_[change].value, places_[change]});
    return changed(now_, made);
}

bool Replay::apply_until(double time, const Follow& simulation) {
    bool any = false;
    while (made_ < changes_.size() && next() <= time) {
        const double when = next();
        SceneFile then = moment(made_);
        if (const auto lines = needs_restart(differences(now_, then)); !lines.empty())
            throw InputError(places_[made_ - 1], lines[0] + " during the run", "", "allowed: keys that may change (whorl live --help)");
        const bool physics = decides(now_, then);
        now_ = std::move(then);
        if (physics) simulation(now_.scene, make_plan(now_.scene), when);
        any = true;
    }
    return any;
}

}  // namespace whorl

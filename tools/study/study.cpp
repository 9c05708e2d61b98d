#include "tools/study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <map>
#include <set>

#include "engine/scene/document.h"
#include "engine/scene/expression_keys.h"
#include "engine/scene/reader.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

using AccuracyNames = std::vector<std::pair<AccuracyKind, const char*>>;
using MomentNames = std::vector<std::pair<Moment, const char*>>;
using CostNames = std::vector<std::pair<CostKind, const char*>>;
AccuracyNames choices(AccuracyKind) {
    using A = AccuracyKind;
    return {{A::exact, "exact"}, {A::reference, "reference"}, {A::conserved, "conserved"}, {A::picture, "picture"}};
}
MomentNames choices(Moment) { return {{Moment::last, "last"}, {Moment::mean, "mean"}, {Moment::all, "all"}}; }
CostNames choices(CostKind) { return {{CostKind::cpu, "cpu"}, {CostKind::wall, "wall"}, {CostKind::memory, "memory"}}; }

namespace {

KeyTable knob_keys() {
    KeyTableOf<Knob> t("a swept setting and its values");
    t.key("key", &Knob::key, "", "a scene key, or scene, quality, threads, program, or a new name for use in braces").required();
    t.key("values", &Knob::values, "", "its values, in order of increasing or decreasing cost").required();
    t.key("label", &Knob::label, "", "name in plots; default: the key");
    return t;
}

KeyTable accuracy_keys() {
    KeyTableOf<AccuracyKeys> t("definition of accuracy");
    t.key("of", &AccuracyKeys::of, "", "error relative to an expression, to a reference run or to the first row, or difference of images");
    t.key("table", &AccuracyKeys::table, "", "path in the run folder: diagnostics.csv, probes/NAME.csv");
    t.key("column", &AccuracyKeys::column, "", "column of the table");
    t.key("at", &AccuracyKeys::at, "", "rows that count: the last, the mean of all, or all (root mean square)");
    t.key("from", &AccuracyKeys::from, "s", "earlier rows are ignored").at_least(0);
    t.key("expected", &AccuracyKeys::expected, "", "the exact value").of("txyz");
    t.key("scale", &AccuracyKeys::scale, "", "divisor of the error; 0: the largest expected value").at_least(0);
    t.key("reference", &AccuracyKeys::reference, "", "settings of the reference run");
    return t;
}

KeyTable cost_keys() {
    KeyTableOf<CostKeys> t("definition of cost");
    t.key("of", &CostKeys::of, "", "CPU seconds, wall seconds, or peak memory");
    t.key("repeat", &CostKeys::repeat, "", "timings per point").at_least(1).at_most(100);
    return t;
}

KeyTable limit_keys() {
    KeyTableOf<LimitKeys> t("a predicted limit, drawn on the map");
    t.key("name", &LimitKeys::name, "", "name in the map's legend").required();
    t.key("value", &LimitKeys::value, "", "limit of the second knob, as an expression of the first knob's value x").required();
    return t;
}

KeyTable stability_keys() {
    KeyTableOf<StabilityKeys> t("definition of stability");
    t.key("noisy_speed", &StabilityKeys::noisy_speed, "m/s",
          "a run is noisy if its largest final speed is above this; default: not checked");
    t.key("energy_growth", &StabilityKeys::energy_growth, "", "relative growth of the energy that is still physical; 0: not checked")
        .at_least(0);
    t.key("energy_scale", &StabilityKeys::energy_scale, "J", "lower bound of the energy that growth is relative to");
    t.key("stalled", &StabilityKeys::stalled, "", "fraction of the solves that may end without convergence").at_least(0).at_most(1);
    t.key("bisect", &StabilityKeys::bisect, "", "key whose largest stable value is found in each cell");
    t.key("low", &StabilityKeys::low, "", "lowest value of the search").at_least(0);
    t.key("high", &StabilityKeys::high, "", "highest value of the search").at_least(0);
    t.key("halvings", &StabilityKeys::halvings, "", "number of times that the search halves the interval of the logarithm")
        .at_least(1)
        .at_most(20);
    t.list("limit", &StabilityKeys::limits, limit_keys());
    return t;
}

const KeyTable& study_keys() {
    static const KeyTable table = [] {
        KeyTableOf<Study> t("a sweep over settings");
        t.key("name", &Study::name, "", "name of the folder of results; default: the file's name");
        t.key("scenes", &Study::scenes, "", "names of shipped scenes, or paths relative to the study's folder").required();
        t.key("quality", &Study::quality, "", "quality of every point").one_of({"draft", "standard", "fine"});
        t.key("set", &Study::set, "", "settings of every point: \"time.end=1\"; {...} contains an expression of the knobs");
        t.key("limit", &Study::limit, "s", "wall time that a point may take").above(0);
        t.key("pictures", &Study::pictures, "", "whether points draw images");
        t.list("knob", &Study::knobs, knob_keys());
        t.part("accuracy", &Study::accuracy, accuracy_keys());
        t.part("cost", &Study::cost, cost_keys());
        t.part("stability", &Study::stability, stability_keys());
        return static_cast<KeyTable>(t);
    }();
    return table;
}

/// Converts the knobs' values, which may be numbers, booleans or strings in the file, to strings.
void values_to_texts(Value& root) {
    Value* knobs = root.find("knob");
    Value::List* list = knobs ? knobs->as<Value::List>() : nullptr;
    if (!list) return;
    for (Value& knob : *list) {
        Value* values = knob.as<Value::Table>() ? knob.find("values") : nullptr;
        if (!values || !values->as<Value::List>()) continue;
        for (Value& v : *values->as<Value::List>())
            if (!v.as<std::string>() && !v.as<Value::Table>()) {
                std::string text = v.toml();
                if (v.as<double>() && text.ends_with(".0")) text.resize(text.size() - 2);
                v.data = std::move(text);
            }
    }
    Value* stability = root.find("stability");
    if (!stability || !stability->as<Value::Table>()) return;
    for (const char* key : {"noisy_speed", "energy_scale"})
        if (Value* text = stability->find(key); text && text->is_number()) text->data = text->toml();
}

bool letter(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

/// The expression with names of knobs replaced by their values. @param others receives all other names
std::string expression_of(const std::string& text, const std::map<std::string, std::string>& values, std::set<std::string>& others) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        if (!letter(text[i]) || std::isdigit(static_cast<unsigned char>(text[i]))) {  // letters belong to the number in 1e-3
            const bool number = letter(text[i]);
            do out += text[i++];
            while (number && i < text.size() && (letter(text[i]) || text[i] == '.'));
            continue;
        }
        std::string name;
        while (i < text.size() && letter(text[i])) name += text[i++];
        const auto found = values.find(name);
        out += found == values.end() ? *others.insert(name).first : "(" + found->second + ")";
    }
    return out;
}

/// Upper bound, because the search evaluates all settings after every run.
constexpr int most_settings = 20000;

/// Checks expressions that a study evaluates only after a cell or at its end, so that an error does not appear after hours.
void check_expressions(const Study& study, Reader& reader) {
    std::vector<std::string> settings;
    for (const Knob& knob : study.knobs)
        if (!knob.values.empty()) settings.push_back(knob.key + "=" + knob.values[0]);
    const auto check = [&](const std::string& key, const std::string& text, const std::string& more) {
        std::vector<std::string> known = settings;
        if (!more.empty()) known.push_back(more);
        try {
            if (!text.empty()) with_values("{" + text + "}", known);
        } catch (const InputError& error) {
            reader.disagree({key}, key + ": " + error.problems().front().what, error.problems().front().hint);
        }
    };
    const StabilityKeys& s = study.stability;
    const std::string bisected = s.bisect.empty() ? "" : fmt::format("{}={:.6g}", s.bisect, s.low);
    check("stability.noisy_speed", s.noisy_speed, bisected);
    check("stability.energy_scale", s.energy_scale, bisected);
    const std::string x = study.knobs.empty() || study.knobs[0].values.empty() ? "" : "x=" + study.knobs[0].values[0];
    for (std::size_t i = 0; i < s.limits.size() && !x.empty(); ++i)
        check(entry_name("stability.limit", i) + ".value", s.limits[i].value, x);
}

void check(const Study& study, Reader& reader) {
    for (std::size_t i = 0; i < study.knobs.size(); ++i) {
        const std::string name = entry_name("knob", i);
        const std::vector<std::string>& values = study.knobs[i].values;
        if (values.size() < 2) reader.disagree({name + ".values"}, name + ".values needs two values or more");
        if (std::set<std::string>(values.begin(), values.end()).size() < values.size())
            reader.disagree({name + ".values"}, name + ".values contains a value twice");
        for (std::size_t j = 0; j < i; ++j)
            if (study.knobs[j].key == study.knobs[i].key)
                reader.disagree({name + ".key"}, name + ".key is already swept by " + entry_name("knob", j));
    }
    double all = 1;
    for (const Knob& knob : study.knobs) all *= static_cast<double>(knob.values.size());
    if (all > most_settings)
        reader.disagree({"knob"}, fmt::format("the knobs have {:.2g} combinations of values", all),
                        "sweep fewer knobs, or fewer values of each", fmt::format("allowed: up to {}", most_settings));
    for (std::size_t i = 0; i < study.knobs.size(); ++i) {
        const std::string& key = study.knobs[i].key;
        const auto uses = [&](const std::string& text) {
            for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{', open + 1))
                if (text.substr(open, text.find('}', open) - open).find(key) != std::string::npos) return true;
            return false;
        };
        if (is_name(key) && std::none_of(study.set.begin(), study.set.end(), uses))
            reader.disagree({entry_name("knob", i) + ".key"}, entry_name("knob", i) + ".key = \"" + key + "\" has no effect",
                            "use a scene key, or use {" + key + "} in set");
    }
    if (study.scenes.empty()) reader.disagree({"scenes"}, "scenes is empty");
    std::set<std::string> names;  // of the result folders
    for (const std::string& scene : study.scenes)
        if (const std::string name = std::filesystem::path(scene).stem(); !names.insert(name).second)
            reader.disagree({"scenes"}, "two of the scenes have the name " + name, "give one of them another name");
    for (const std::vector<std::string>* settings : {&study.set, &study.accuracy.reference})
        for (const std::string& setting : *settings)
            if (setting.find('=') == std::string::npos)
                reader.disagree({settings == &study.set ? "set" : "accuracy.reference"}, "\"" + setting + "\" is not a setting", "",
                                "allowed: \"key=value\"");
    check_expressions(study, reader);
    const StabilityKeys& s = study.stability;
    if (!s.bisect.empty() && !(0 < s.low && s.low < s.high))
        reader.disagree({"stability.high", "stability.low", "stability.bisect"},
                        "stability.bisect needs 0 < stability.low < stability.high");
}

}  // namespace

bool is_name(const std::string& key) {
    static const std::vector<std::string> options{"scene", "quality", "threads", "program", "seed", "name"};
    return key.find('.') == std::string::npos && std::find(options.begin(), options.end(), key) == options.end();
}

std::string scene_of(const Study& study, const std::string& scene) {
    const std::filesystem::path local = study.directory / scene;
    return std::filesystem::is_regular_file(local) ? local.string() : scene;
}

std::string with_values(const std::string& text, const std::vector<std::string>& settings) {
    std::map<std::string, std::string> values;
    std::map<std::string, std::set<std::string>> keys;  // keys with this last word
    for (const std::string& setting : settings) {
        const std::string key = setting.substr(0, setting.find('=')), name = key.substr(key.rfind('.') + 1);
        keys[name].insert(key);
        if (key == name || !keys[name].contains(name))
            values[name] = setting.substr(key.size() + 1);  // a key equal to the name has priority
    }
    const auto unclear = [&](const std::string& name) {
        return keys.contains(name) && keys[name].size() > 1 && !keys[name].contains(name);
    };
    std::erase_if(values, [&](const auto& value) { return unclear(value.first); });
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t close = text[i] == '{' ? text.find('}', i) : std::string::npos;
        if (close == std::string::npos) {
            out += text[i++];
            continue;
        }
        const std::string inside = text.substr(i + 1, close - i - 1);
        i = close + 1;
        if (const auto word = values.find(inside); word != values.end()) {
            out += word->second;
            continue;
        }
        std::set<std::string> others;
        try {
            out += fmt::format("{:.9g}", Expression(expression_of(inside, values, others))(0));
        } catch (const ExpressionError& error) {
            const auto name = std::find_if(others.begin(), others.end(), unclear);
            throw InputError({text, 0, 0}, fmt::format("{{{}}} is not an expression of the knobs: {}", inside, error.what()),
                             name == others.end() ? "" : "two knobs are called " + *name + "; rename one of them");
        }
    }
    return out;
}

std::vector<std::string> run_settings(const Study& study, const std::vector<std::string>& settings) {
    std::vector<std::string> all;
    for (const std::string& setting : study.set) all.push_back(with_values(setting, settings));
    for (const std::string& setting : settings)
        if (!is_name(setting.substr(0, setting.find('=')))) all.push_back(with_values(setting, settings));
    return all;
}

std::vector<std::string> settings_at(const Study& study, const GridPoint& p) {
    std::vector<std::string> settings;
    for (std::size_t k = 0; k < study.knobs.size(); ++k) settings.push_back(study.knobs[k].key + "=" + study.knobs[k].values[p[k]]);
    return settings;
}

std::string label_at(const Study& study, const GridPoint& p) {
    std::string label;
    for (std::size_t k = 0; k < study.knobs.size(); ++k) {
        const std::string& value = study.knobs[k].values[p[k]];
        char* end = nullptr;
        const double number = std::strtod(value.c_str(), &end);
        label += (k ? ", " : "") + (*end == 0 && value.size() > 7 ? fmt::format("{:.3g}", number) : value);
    }
    return label;
}

double seconds_of(const std::string& budget) {
    if (budget.empty()) return 0;
    char* end = nullptr;
    const double number = std::strtod(budget.c_str(), &end);
    const std::string unit = end;
    const double scale = unit.empty() || unit == "s" ? 1 : unit == "min" || unit == "m" ? 60 : unit == "h" ? 3600 : 0;
    if (end == budget.c_str() || scale == 0 || !(number > 0))
        throw InputError({"--budget " + budget, 0, 0}, "is not a duration", "", "allowed: for example 90s, 10min, 1h");
    return number * scale;
}

Study read_study(const std::string& name) {
    const std::filesystem::path file = find_study(name);
    Value root = parse_toml_file(file.string());
    values_to_texts(root);
    Study study;
    study.name = file.stem().string();
    study.directory = file.parent_path();
    Reader reader(study_keys(), &study, {});
    reader.read(root);
    check(study, reader);
    if (!reader.problems.empty()) throw InputError(in_order(std::move(reader.problems), file.string()));
    for (std::string& scene : study.scenes) scene = scene_of(study, scene);
    return study;
}

}  // namespace whorl

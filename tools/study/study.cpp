#include "tools/study/study.h"

#include <algorithm>

#include "engine/scene/document.h"
#include "engine/scene/expression_keys.h"
#include "engine/scene/reader.h"
#include "tools/options.h"

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
    KeyTableOf<Knob> t("a setting and the values that it takes");
    t.key("key", &Knob::key, "", "a scene key, or scene, quality, threads, program").required();
    t.key("values", &Knob::values, "", "its values, in order from cheap to dear or the other way round").required();
    return t;
}

KeyTable accuracy_keys() {
    KeyTableOf<AccuracyKeys> t("what accuracy means");
    t.key("of", &AccuracyKeys::of, "", "against an expression, against a run that counts as true, against the first row, or between pictures");
    t.key("table", &AccuracyKeys::table, "", "in the run folder: diagnostics.csv, probes/NAME.csv");
    t.key("column", &AccuracyKeys::column, "", "of the table");
    t.key("at", &AccuracyKeys::at, "", "the newest row, the mean of the rows, or all rows");
    t.key("from", &AccuracyKeys::from, "s", "earlier rows do not count").at_least(0);
    t.key("expected", &AccuracyKeys::expected, "", "the exact value").of("txyz");
    t.key("scale", &AccuracyKeys::scale, "", "what the error is divided by; 0: the largest expected value").at_least(0);
    t.key("reference", &AccuracyKeys::reference, "", "settings of the run that counts as true");
    return t;
}

KeyTable cost_keys() {
    KeyTableOf<CostKeys> t("what cost means");
    t.key("of", &CostKeys::of, "", "CPU seconds, wall seconds, or peak memory");
    t.key("repeat", &CostKeys::repeat, "", "timings of each point").at_least(1).at_most(100);
    return t;
}

KeyTable stability_keys() {
    KeyTableOf<StabilityKeys> t("what stable means");
    t.key("noisy_speed", &StabilityKeys::noisy_speed, "m/s", "a run whose fastest particle ends above it is noisy; 0: not asked").at_least(0);
    t.key("energy_growth", &StabilityKeys::energy_growth, "", "of the scene's energy; more is unphysical; 0: not asked").at_least(0);
    t.key("stalled", &StabilityKeys::stalled, "", "part of the solves that may end without convergence").at_least(0).at_most(1);
    t.key("bisect", &StabilityKeys::bisect, "", "key whose largest stable value is searched for in each cell");
    t.key("low", &StabilityKeys::low, "", "its lowest value").at_least(0);
    t.key("high", &StabilityKeys::high, "", "its highest value").at_least(0);
    t.key("halvings", &StabilityKeys::halvings, "", "of the interval between them, of its logarithm").at_least(1).at_most(20);
    return t;
}

const KeyTable& study_keys() {
    static const KeyTable table = [] {
        KeyTableOf<Study> t("a sweep over settings");
        t.key("name", &Study::name, "", "names the folder of its results; default: the file's name");
        t.key("scenes", &Study::scenes, "", "names of shipped scenes, or files found from the study's folder").required();
        t.key("quality", &Study::quality, "", "of every point").one_of({"draft", "standard", "fine"});
        t.key("set", &Study::set, "", "settings of every point: \"time.end=1\"");
        t.key("limit", &Study::limit, "s", "wall time that a point may take").above(0);
        t.key("pictures", &Study::pictures, "", "draw too");
        t.list("knob", &Study::knobs, knob_keys());
        t.part("accuracy", &Study::accuracy, accuracy_keys());
        t.part("cost", &Study::cost, cost_keys());
        t.part("stability", &Study::stability, stability_keys());
        return static_cast<KeyTable>(t);
    }();
    return table;
}

/// Values stand in the file as numbers, flags or texts; settings are texts.
void values_to_texts(Value& root) {
    Value* knobs = root.find("knob");
    Value::List* list = knobs ? knobs->as<Value::List>() : nullptr;
    if (!list) return;
    for (Value& knob : *list) {
        Value* values = knob.as<Value::Table>() ? knob.find("values") : nullptr;
        if (!values || !values->as<Value::List>()) continue;
        for (Value& v : *values->as<Value::List>())
            if (!v.as<std::string>() && !v.as<Value::Table>()) v.data = v.toml();
    }
}

void check(const Study& study, Reader& reader) {
    for (std::size_t i = 0; i < study.knobs.size(); ++i) {
        const std::string name = entry_name("knob", i);
        if (study.knobs[i].values.size() < 2) reader.disagree({name + ".values"}, name + ".values needs two values or more");
        for (std::size_t j = 0; j < i; ++j)
            if (study.knobs[j].key == study.knobs[i].key) reader.disagree({name + ".key"}, name + ".key is swept by " + entry_name("knob", j) + " already");
    }
    if (study.scenes.empty()) reader.disagree({"scenes"}, "scenes is empty");
    for (const std::vector<std::string>* settings : {&study.set, &study.accuracy.reference})
        for (const std::string& setting : *settings)
            if (setting.find('=') == std::string::npos)
                reader.disagree({settings == &study.set ? "set" : "accuracy.reference"}, "\"" + setting + "\" is no setting", "", "allowed: \"key=value\"");
    const StabilityKeys& s = study.stability;
    if (!s.bisect.empty() && !(0 < s.low && s.low < s.high))
        reader.disagree({"stability.high", "stability.low", "stability.bisect"}, "stability.bisect needs 0 < stability.low < stability.high");
}

}  // namespace

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
    for (std::string& scene : study.scenes)
        if (const auto beside = study.directory / scene; std::filesystem::is_regular_file(beside)) scene = beside.string();
    return study;
}

}  // namespace whorl

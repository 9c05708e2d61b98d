#pragma once
/// Study files: which settings of which scene are swept, what counts as accurate or stable, what counts as cost.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/math/expression.h"

namespace whorl {

enum class AccuracyKind { exact, reference, conserved, picture };
enum class Moment { last, mean, all };
enum class CostKind { cpu, wall, memory };

/// One setting and the values that it takes.
struct Knob {
    std::string key;                  ///< a scene key; or scene, quality, threads, program; or a new name, which settings use in braces
    std::vector<std::string> values;  ///< as --set takes them
    std::string label;                ///< what pictures call it; "": the key
    const std::string& title() const { return label.empty() ? key : label; }
};

struct AccuracyKeys {
    AccuracyKind of = AccuracyKind::exact;
    std::string table = "diagnostics.csv";  ///< in the run folder: "probes/coil.csv"
    std::string column;
    Moment at = Moment::last;            ///< the last row, the mean of the rows, or the root of the mean square of every row's error
    double from = 0;                     ///< s; earlier rows do not count
    Expression expected{0.0};            ///< exact: of t, and of x, y, z where the table has such columns
    double scale = 0;                    ///< what the error is divided by; 0: the largest expected value
    std::vector<std::string> reference;  ///< settings of the run that counts as true
};

struct CostKeys {
    CostKind of = CostKind::cpu;
    int repeat = 1;  ///< timings of a point: more give error bars
};

/// A limit that theory predicts, as a line on the map.
struct LimitKeys {
    std::string name;
    std::string value;  ///< of the second knob; an expression of the first one's value x, braces allowed
};

struct StabilityKeys {
    std::string noisy_speed;  ///< m/s; a run whose fastest particle ends above it is noisy; braces allowed; "": not asked
    double energy_growth =
        0.05;                  ///< of the scene's own energy; more is unphysical; 0: not asked (emitters and moving solids feed energy in)
    std::string energy_scale;  ///< J; growth is measured against what moved, but at least against this; braces allowed; "": 0
    double stalled = 0.05;     ///< part of the solves that may end without convergence
    std::string bisect;        ///< key whose largest stable value is searched for in each cell; "": none
    double low = 0, high = 0;  ///< between these, halving the interval of its logarithm
    int halvings = 5;
    std::vector<LimitKeys> limits;
};

struct Study {
    std::string name;
    std::vector<std::string> scenes;  ///< names of shipped scenes, or files found from the study's folder
    std::string quality = "standard";
    std::vector<std::string> set;  ///< for every point; "{...}" is replaced by the value of an expression of the knobs: "time.end={40*dt}"
    double limit = 600;            ///< s of wall time a point may take
    bool pictures = false;         ///< draw too (an accuracy of kind picture does so anyway)
    std::vector<Knob> knobs;
    AccuracyKeys accuracy;
    CostKeys cost;
    StabilityKeys stability;
    std::filesystem::path directory;  ///< of the study file
};

/// A scene that the study names: a file found from the study's folder, or else the name as it is.
std::string scene_of(const Study& study, const std::string& scene);
/// The settings of a run as --set takes them: the study's own, then those of its knobs, with every "{...}" replaced by its value.
/// @param settings "key=value" of each knob @throws InputError
std::vector<std::string> run_settings(const Study& study, const std::vector<std::string>& settings);
/// A text with every "{...}" replaced by its value. @param settings values of names: "scale", a new name, or the
/// last word of "solid[0].scale" alone
std::string with_values(const std::string& text, const std::vector<std::string>& settings);
/// Whether a knob is no setting itself, but a name that settings use.
bool is_name(const std::string& key);

/// A point of the knobs' grid: the number of each knob's value.
using GridPoint = std::vector<int>;
/// The settings at a point of the grid: "key=value" for each knob.
std::vector<std::string> settings_at(const Study& study, const GridPoint& p);
/// Values as labels: "0.002, 0.01".
std::string label_at(const Study& study, const GridPoint& p);
/// "90", "90s", "10min", "1.5h" in seconds; 0 for "". @throws InputError
double seconds_of(const std::string& budget);

/// @param file a path, or the name of a study that ships @throws InputError with all that is wrong
Study read_study(const std::string& file);

}  // namespace whorl

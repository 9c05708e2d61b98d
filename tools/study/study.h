#pragma once
/// Study files: scenes, the settings to sweep, and the definitions of accuracy, stability and cost.
#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/errors.h"
#include "engine/math/expression.h"

namespace whorl {

enum class AccuracyKind { exact, reference, conserved, picture };
enum class Moment { last, mean, all };
enum class CostKind { cpu, wall, memory };

/// A swept setting and its values.
struct Knob {
    std::string key;                  ///< a scene key; or scene, quality, threads, program; or a new name for use in braces
    std::vector<std::string> values;  ///< in the syntax of --set
    std::string label;                ///< name in plots; "": the key
    const std::string& title() const { return label.empty() ? key : label; }
};

struct AccuracyKeys {
    AccuracyKind of = AccuracyKind::exact;
    std::string table = "diagnostics.csv";  ///< path in the run folder
    std::string column;
    Moment at = Moment::last;            ///< rows that count: the last; the mean of all; or all, as root mean square of their errors
    double from = 0;                     ///< s; earlier rows are ignored
    Expression expected{0.0};            ///< of kind exact; expression of t, and of x, y, z if the table has these columns
    double scale = 0;                    ///< divisor of the error; 0: the largest expected value
    std::vector<std::string> reference;  ///< settings of the reference run
};

struct CostKeys {
    CostKind of = CostKind::cpu;
    int repeat = 1;  ///< timings per point; two or more give error bars
};

/// A limit that theory predicts, as a line on the map.
struct LimitKeys {
    std::string name;
    std::string value;  ///< of the second knob, as an expression of the first knob's value x; braces allowed
};

struct StabilityKeys {
    std::string noisy_speed;      ///< m/s; a run is noisy if its largest final speed is above this; braces allowed; "": not checked
    double energy_growth = 0.05;  ///< relative; more is unphysical; 0: not checked (emitters and moving solids add energy)
    std::string energy_scale;     ///< J; lower bound of the energy that growth is relative to; braces allowed; "": 0
    double stalled = 0.05;        ///< fraction of the solves that may end without convergence
    std::string bisect;           ///< key whose largest stable value is found in each cell; "": none
    double low = 0, high = 0;     ///< range of the search, which halves the interval of the logarithm
    int halvings = 5;
    std::vector<LimitKeys> limits;
};

struct Study {
    std::string name;
    std::vector<std::string> scenes;  ///< names of shipped scenes, or paths relative to the study's folder
    std::string quality = "standard";
    std::vector<std::string> set;  ///< settings of every point; in "time.end={40*dt}", the braces contain an expression of the knobs
    double limit = 600;            ///< wall time that a point may take, s
    bool pictures = false;         ///< whether points draw images (always if the accuracy is of kind picture)
    std::vector<Knob> knobs;
    AccuracyKeys accuracy;
    CostKeys cost;
    StabilityKeys stability;
    std::filesystem::path directory;  ///< of the study file
};

/// A scene of the study: its path if the file exists relative to the study's folder, else the name unchanged.
std::string scene_of(const Study& study, const std::string& scene);
/// Settings of a run in the syntax of --set: the study's own, then those of its knobs. Every "{...}" is replaced by its value.
/// @param settings "key=value" of each knob @throws InputError
std::vector<std::string> run_settings(const Study& study, const std::vector<std::string>& settings);
/// The text with every "{...}" replaced by the value of its expression. @param settings "key=value"; expressions use a key by its last word
/// (scale for solid[0].scale)
std::string with_values(const std::string& text, const std::vector<std::string>& settings);
/// Whether a knob's key is a new name for use in braces, not a setting.
bool is_name(const std::string& key);

/// A point of the knobs' grid: the index of each knob's value.
using GridPoint = std::vector<int>;
/// Settings at a point of the grid: "key=value" for each knob.
std::vector<std::string> settings_at(const Study& study, const GridPoint& p);
/// Values as labels: "0.002, 0.01".
std::string label_at(const Study& study, const GridPoint& p);
/// "90", "90s", "10min", "1.5h" in seconds; 0 for "". @throws InputError
double seconds_of(const std::string& budget);

/// @param file a path, or the name of a shipped study @throws InputError with all errors of the file
Study read_study(const std::string& file);

}  // namespace whorl

#pragma once
/// Common loop of a film and a live run: advances a simulation from frame to frame. Probes see every step, the solvers' residuals are
/// recorded, accuracy is reduced for the budget, and changes of the scene are applied.
#include <string>

#include "engine/io/diagnostics.h"
#include "engine/probes/probes.h"
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Reduction of quality, from 0 (none) to 4 (all): each unit uses up one of the four settings, on a logarithmic scale.
struct QualityReduction {
    double amount = 0;
    double tolerance = 1, cfl = 0, voxel = 0;  ///< factor; value; value
    int samples = 0;
};

/// Keeps a run to its budget of time by giving up accuracy in a set order, within bounds that the scene sets: first the solvers'
/// tolerances, then the length of steps, then the surface's voxels, then samples per pixel. Never the fluid.
class Governor {
public:
    /// @param given the scene as the user wants it @param frames of the film
    Governor(const SceneFile& given, int frames);

    /// The user's scene is another one from now on.
    void set_scene(const SceneFile& given);
    /// After a frame. @param seconds it took, wall @param frame its number @param spent s, wall, over the whole run
    /// @return whether the reductions changed
    bool after_frame(double seconds, int frame, double spent);
    /// The scene with the current reductions.
    SceneFile governed() const;

    bool has_budget() const { return given_.scene.budget.any(); }
    double allowed() const { return allowed_; }  ///< s, of the last frame
    QualityReduction now() const;

private:
    SceneFile given_;
    int frames_;
    double amount_ = 0, allowed_ = 0;
};

/// The columns of budget.csv: what the frame took and was allowed, what was given up, and what that did to what can be measured.
std::string budget_header();

/// Who runs the loop: a film, or a live run.
class FrameLoopHost {
public:
    virtual ~FrameLoopHost() = default;
    /// Asked before every step: whether to stop on the way.
    virtual bool stop_wanted() = 0;
    /// May change the scene for the next step. @param began s, at the step's start
    virtual void after_step(const StepReport& /*report*/, double /*began*/) {}
    /// From now on pictures are made as `file` says.
    virtual void set_pictures(const SceneFile& file) = 0;
};

/// A frame that was reached.
struct FrameSummary {
    Measures measures;
    RunTotals before;       ///< at the frame before
    long steps = 0;         ///< since then
    double iterations = 0;  ///< of all solvers, a step
};

class FrameLoop {
public:
    /// @param file the scene as the user wants it @param frames of the film
    FrameLoop(FrameLoopHost& host, Simulation& simulation, const SceneFile& file, int frames, TheorySearch search);

    /// @param time s @return false if the host stopped it, or the run diverged
    bool step_to(double time);
    /// Measures the frame that was reached.
    FrameSummary measure_frame();
    /// Compares what the frame took with the budget.
    /// @param seconds it took, wall @param spent s, wall, over the whole run @return the row of budget.csv; "" without a budget
    std::string hold_to_budget(const FrameSummary& summary, int frame, double seconds, double spent);
    /// Continues as the last hold_to_budget() decided.
    void apply_governor();
    /// The user's scene is another one now; the simulation knows it already.
    void scene_changed(const SceneFile& file);

    const NamedProbes& probes() const { return probes_; }
    const Governor& governor() const { return governor_; }
    /// Relative; of the solves since the last frame.
    double largest_residual() const { return largest_residual_; }

private:
    void apply(const SceneFile& file);

    FrameLoopHost& host_;
    Simulation& simulation_;
    NamedProbes probes_;
    Governor governor_;
    bool decided_ = false;  ///< the governor has reductions that were not applied
    RunTotals totals_at_frame_;
    double largest_residual_ = 0;
};

}  // namespace whorl

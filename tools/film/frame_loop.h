#pragma once
/// Common loop of `whorl render` and `whorl live`: advances a simulation from frame to frame. It calls the probes after every step, records
/// the solvers' largest residual, reduces accuracy if the scene has a budget of time, and follows changes of the scene.
#include <string>

#include "engine/io/diagnostics.h"
#include "engine/probes/probes.h"
#include "engine/scene/plan.h"
#include "tools/scene_file/scene_file.h"

namespace whorl {

/// Reduction of quality. `amount` goes from 0 (none) to 4 (all): each unit moves one of the four settings from its value in the scene to
/// its bound in [budget], on a logarithmic scale.
struct QualityReduction {
    double amount = 0;
    double tolerance = 1, cfl = 0, voxel = 0;  ///< factor on the tolerances; time.cfl; surface.voxel [spacings]
    int samples = 0;                           ///< per pixel
};

/// Keeps a run within its budget of wall time. It reduces accuracy within the bounds of [budget], in this order: the solvers' tolerances,
/// the length of steps, the surface's voxels, the samples per pixel. The number of particles never changes.
class Governor {
public:
    /// @param given the scene without reductions @param frames number of frames of the run
    Governor(const SceneFile& given, int frames);

    /// Replaces the scene without reductions.
    void set_scene(const SceneFile& given);
    /// Adjusts the reductions after a frame. @param seconds wall time of the frame [s] @param frame its number
    /// @param spent wall time of the whole run [s] @return whether the reductions changed
    bool after_frame(double seconds, int frame, double spent);
    /// The scene with the current reductions.
    SceneFile governed() const;

    bool has_budget() const { return given_.scene.budget.any(); }
    double allowed() const { return allowed_; }  ///< wall time for the last frame [s]
    QualityReduction now() const;

private:
    SceneFile given_;
    int frames_;
    double amount_ = 0, allowed_ = 0;
};

/// Header of budget.csv: wall time and budget of each frame, the reductions, and the resulting residual, unconverged solves and density
/// errors.
std::string budget_header();

/// Callbacks of the loop; a run and a live run implement them.
class FrameLoopHost {
public:
    virtual ~FrameLoopHost() = default;
    /// Called before every step. @return true to stop before the frame time
    virtual bool stop_wanted() = 0;
    /// Called after every step; may change the scene for the next one. @param began time at the start of the step [s]
    virtual void after_step(const StepReport& /*report*/, double /*began*/) {}
    /// Uses the surface, camera and look of `file` for the following images.
    virtual void set_pictures(const SceneFile& file) = 0;
};

/// Measurements of a frame and of the steps that led to it.
struct FrameSummary {
    Measures measures;
    RunTotals before;       ///< at the previous frame
    long steps = 0;         ///< since the previous frame
    double iterations = 0;  ///< of all solvers, per step
};

class FrameLoop {
public:
    /// @param file the scene without reductions @param frames number of frames of the run
    FrameLoop(FrameLoopHost& host, Simulation& simulation, const SceneFile& file, int frames, TheorySearch search);

    /// Steps until this time [s]. @return false if the host stopped the loop or the run diverged
    bool step_to(double time);
    /// Measures the current state, at a frame time.
    FrameSummary measure_frame();
    /// Compares the wall time of a frame with the budget and chooses the next reductions, which apply_governor() applies.
    /// @param seconds wall time of the frame [s] @param spent wall time of the whole run [s] @return row of budget.csv; "" without a budget
    std::string hold_to_budget(const FrameSummary& summary, int frame, double seconds, double spent);
    /// Applies the reductions that the last hold_to_budget() chose to the simulation and the images.
    void apply_governor();
    /// Replaces the scene without reductions, which the simulation already has.
    void scene_changed(const SceneFile& file);

    const NamedProbes& probes() const { return probes_; }
    const Governor& governor() const { return governor_; }
    /// Largest relative residual of the solves since the last frame.
    double largest_residual() const { return largest_residual_; }

private:
    void apply(const SceneFile& file);

    FrameLoopHost& host_;
    Simulation& simulation_;
    NamedProbes probes_;
    Governor governor_;
    bool decided_ = false;  ///< the governor changed its reductions, and they are not applied yet
    RunTotals totals_at_frame_;
    double largest_residual_ = 0;
};

}  // namespace whorl

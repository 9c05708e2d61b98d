#pragma once
/// Names of the choices in scene files, plans and run.json.
#include <utility>
#include <vector>

#include "engine/scene/model_traits.h"

namespace whorl {

template <class E>
using Choices = std::vector<std::pair<E, const char*>>;

/// The rows' names. A name of several rows occurs once.
template <class Traits>
auto row_choices(const std::vector<Traits>& rows) {
    Choices<decltype(Traits::model)> all;
    for (const Traits& row : rows)
        if (all.empty() || all.back().first != row.model) all.emplace_back(row.model, row.name);
    return all;
}
template <class E>
Choices<E> with_automatic(Choices<E> all) {
    all.insert(all.begin(), {E::automatic, "auto"});
    return all;
}

inline Choices<PressureModel> choices(PressureModel) { return with_automatic(row_choices(pressure_models())); }
inline Choices<ViscosityModel> choices(ViscosityModel) { return with_automatic(row_choices(viscosity_models())); }
inline Choices<MicropolarModel> choices(MicropolarModel) { return row_choices(micropolar_models()); }
inline Choices<BoundaryModel> choices(BoundaryModel) {
    using B = BoundaryModel;
    return {{B::automatic, "auto"}, {B::none, "none"}, {B::akinci, "akinci"}, {B::ppe, "ppe"}};
}
inline Choices<ShiftingModel> choices(ShiftingModel) {
    using S = ShiftingModel;
    return {{S::automatic, "auto"}, {S::none, "none"}, {S::fickian, "fickian"}};
}
inline Choices<WallImages> choices(WallImages) {
    return {{WallImages::automatic, "auto"}, {WallImages::none, "none"}, {WallImages::flat, "flat"}};
}
inline Choices<Notes> choices(Notes) { return {{Notes::amended, "amended"}, {Notes::as_printed, "as_printed"}}; }
inline Choices<Preconditioner> choices(Preconditioner) {
    return {{Preconditioner::automatic, "auto"},
            {Preconditioner::none, "none"},
            {Preconditioner::jacobi, "jacobi"},
            {Preconditioner::multigrid, "multigrid"}};
}
inline Choices<ViscousPreconditioner> choices(ViscousPreconditioner) {
    using P = ViscousPreconditioner;
    return {{P::automatic, "auto"}, {P::none, "none"}, {P::block_jacobi, "block_jacobi"}, {P::two_level, "two_level"}};
}
inline Choices<PressureForm> choices(PressureForm) {
    return {{PressureForm::constraint, "constraint"}, {PressureForm::projection, "projection"}};
}
inline Choices<PressureSource> choices(PressureSource) {
    return {{PressureSource::velocity, "velocity"}, {PressureSource::density, "density"}};
}
inline Choices<MultigridCycle> choices(MultigridCycle) {
    return {{MultigridCycle::additive, "additive"}, {MultigridCycle::v_cycle, "v_cycle"}};
}
inline Choices<GradientForm> choices(GradientForm) {
    return {{GradientForm::symmetric, "symmetric"}, {GradientForm::difference, "difference"}};
}
inline Choices<LaplacianForm> choices(LaplacianForm) {
    return {{LaplacianForm::brookshaw, "brookshaw"}, {LaplacianForm::monaghan, "monaghan"}, {LaplacianForm::split, "split"}};
}
inline Choices<ExchangeScheme> choices(ExchangeScheme) {
    using E = ExchangeScheme;
    return {{E::automatic, "auto"}, {E::explicit_steps, "explicit"}, {E::implicit, "implicit"}};
}
inline Choices<WallSpin> choices(WallSpin) { return {{WallSpin::solid, "solid"}, {WallSpin::free, "free"}}; }
inline Choices<CurlForm> choices(CurlForm) {
    return {{CurlForm::symmetric, "symmetric"},
            {CurlForm::difference, "difference"},
            {CurlForm::difference_own_density, "difference_own_density"}};
}
inline Choices<Sampling> choices(Sampling) {
    return {{Sampling::lattice, "lattice"}, {Sampling::jittered, "jittered"}, {Sampling::blue_noise, "blue_noise"}};
}
inline Choices<Slip> choices(Slip) { return {{Slip::no, "no"}, {Slip::free, "free"}, {Slip::navier, "navier"}}; }
inline Choices<Profile> choices(Profile) { return {{Profile::plug, "plug"}, {Profile::parabolic, "parabolic"}}; }
inline Choices<ProbeKind> choices(ProbeKind) {
    using P = ProbeKind;
    return {{P::point, "point"}, {P::line, "line"},   {P::region, "region"}, {P::flow, "flow"},     {P::solid, "solid"},
            {P::coil, "coil"},   {P::level, "level"}, {P::flux, "flux"},     {P::extent, "extent"}, {P::gauge, "gauge"}};
}
inline Choices<KernelKind> choices(KernelKind) {
    using K = KernelKind;
    return {{K::cubic, "cubic"}, {K::wendland_c2, "wendland_c2"}, {K::wendland_c4, "wendland_c4"}};
}

/// The name of a choice in files: name_of(PressureModel::ppe) is "ppe".
template <class E>
const char* name_of(E value) {
    for (const auto& [v, name] : choices(value))
        if (v == value) return name;
    return "?";
}

}  // namespace whorl

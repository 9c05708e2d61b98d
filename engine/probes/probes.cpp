#include "engine/probes/probes.h"

#include <algorithm>

#include "engine/core/parallel.h"
#include "engine/io/columns.h"
#include "engine/io/csv.h"
#include "engine/probes/coil_probe.h"
#include "engine/probes/experiments.h"
#include "engine/probes/interpolation.h"

namespace whorl {
namespace {

class RegionProbe : public Probe {
public:
    explicit RegionProbe(const ProbeKeys& keys) : min_(keys.min), max_(keys.max) {}

    ProbeColumns columns() const override {
        return ProbeColumns{{"time", "s", ""}, {"particles", "", ""}, {"mass", "kg", "mass"}} + vector_columns("centroid", "m") +
               vector_columns("velocity", "m/s") + vector_columns("spin", "1/s");
    }

    ProbeRows rows(const World& world, double time) override {
        const auto x = world.fluid.column<field::position>();
        const auto u = world.fluid.column<field::velocity>();
        const Span<const Vec3> spin = world.fluid.has<field::spin>() ? world.fluid.column<field::spin>() : Span<const Vec3>();
        const auto role = roles(world);
        using Sums = Eigen::Array<double, 10, 1>;  // count, x, u, spin
        const Sums sums = parallel_sum(world.fluid.size(), Sums(Sums::Zero()), [&](Index i) {
            const auto k = static_cast<std::size_t>(i);
            Vec3d xi = x[k].cast<double>();
            Sums s = Sums::Zero();
            if (in_nozzle(role, k) || !world.step.domain.image_in_box(xi, min_, max_)) return s;
            s[0] = 1;
            s.segment<3>(1) = xi.array();
            s.segment<3>(4) = u[k].cast<double>().array();
            if (!spin.empty()) s.segment<3>(7) = spin[k].cast<double>().array();
            return s;
        });
        std::vector<double> row{time, sums[0], sums[0] * static_cast<double>(world.step.mass)};
        for (int k = 1; k < 10; ++k) row.push_back(sums[0] > 0 ? sums[k] / sums[0] : unknown);
        return {row};
    }

private:
    Vec3d min_, max_;
};

/// Fields interpolated at the points of a line, or at a single point.
class PointsProbe : public Probe {
public:
    PointsProbe(std::vector<Vec3d> points, bool line, const World& world) : points_(std::move(points)), line_(line) {
        for (const std::string& name : quantity_names())
            if (name != "position" && world.fluid.find(name) != nullptr) names_.push_back(name);
        columns_ = {{"time", "s", ""}};
        if (line) columns_ = columns_ + ProbeColumns{{"s", "m", ""}, {"x", "m", ""}, {"y", "m", ""}, {"z", "m", ""}};
        for (const NumberColumn& column : columns_named(world.fluid, names_))
            for (const std::string& name : component_names(column))
                columns_.push_back({name, std::string(world.fluid.find(column.name)->info->unit), line ? name : column.name});
    }

    ProbeColumns columns() const override { return columns_; }
    std::size_t along() const override { return line_ ? 1 : 0; }

    ProbeRows rows(const World& world, double time) override {
        const std::vector<NumberColumn> columns = columns_named(world.fluid, names_);
        ProbeRows rows;
        const std::vector<Interpolation> near = interpolate(world, points_);
        for (std::size_t k = 0; k < points_.size(); ++k) {
            const Vec3d& point = points_[k];
            std::vector<double>& row = rows.emplace_back(std::vector<double>{time});
            if (line_) row.insert(row.end(), {(point - points_.front()).norm(), point.x(), point.y(), point.z()});
            for (double value : interpolated(columns, near[k])) row.push_back(value);
        }
        return rows;
    }

private:
    static std::vector<double> interpolated(const std::vector<NumberColumn>& columns, const Interpolation& near) {
        std::vector<double> values;
        for (const NumberColumn& column : columns)
            for (int c = 0; c < column.components; ++c) {
                double sum = near.shares.empty() ? unknown : 0;
                for (const Interpolation::Share& one : near.shares) sum += one.weight * column.value(one.particle, c);
                values.push_back(sum);
            }
        return values;
    }

    std::vector<Vec3d> points_;
    bool line_;
    std::vector<std::string> names_;
    ProbeColumns columns_;
};

}  // namespace

std::unique_ptr<Probe> make_probe(const ProbeKeys& keys, const World& world, TheorySearch search) {
    switch (keys.kind) {
        case ProbeKind::region: return std::make_unique<RegionProbe>(keys);
        case ProbeKind::flow: return make_flow_probe(keys);
        case ProbeKind::solid: return make_solid_probe(keys);
        case ProbeKind::coil: return std::make_unique<CoilProbe>(keys, search);
        case ProbeKind::level: return make_level_probe(keys);
        case ProbeKind::flux: return make_flux_probe(keys, world);
        case ProbeKind::gauge: return make_gauge_probe(keys, world);
        case ProbeKind::extent: return make_extent_probe(keys);
        case ProbeKind::point: return std::make_unique<PointsProbe>(std::vector<Vec3d>{keys.at}, false, world);
        case ProbeKind::line: break;
    }
    std::vector<Vec3d> points;
    for (int k = 0; k < keys.count; ++k)
        points.push_back(keys.from + (keys.to - keys.from) * (keys.count > 1 ? k / (keys.count - 1.0) : 0.0));
    return std::make_unique<PointsProbe>(std::move(points), true, world);
}

NamedProbes make_probes(const Simulation& simulation, TheorySearch search) {
    NamedProbes probes;
    for (const ProbeKeys& keys : simulation.scene().probes) probes.emplace_back(keys.name, make_probe(keys, simulation.world(), search));
    return probes;
}

ProbeRows rows_of(Probe& probe, const Simulation& simulation) {
    probe.set_scene(simulation.scene(), simulation.plan());
    return probe.rows(simulation.world(), simulation.time());
}

namespace {

constexpr const char* theory = "theory_";

bool has(const ProbeColumns& columns, const std::string& name) {
    return std::any_of(columns.begin(), columns.end(), [&](const ProbeColumn& c) { return c.name == name; });
}

std::string label_of(const ProbeColumn& column, const ProbeColumns& all) {
    if (column.name.rfind(theory, 0) == 0) return "theory";
    if (has(all, theory + column.name)) return "measured";
    const std::string stem = column.plot + "_";
    return column.name.rfind(stem, 0) == 0 ? column.name.substr(stem.size()) : column.name;
}

}  // namespace

ProbeColumns vector_columns(const std::string& name, const std::string& unit) {
    return {{name + "_x", unit, name}, {name + "_y", unit, name}, {name + "_z", unit, name}};
}

ProbeColumns operator+(ProbeColumns a, const ProbeColumns& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

std::vector<ProbePlot> plots_of(const ProbeColumns& columns) {
    std::vector<ProbePlot> plots;
    for (std::size_t k = 0; k < columns.size(); ++k) {
        const ProbeColumn& c = columns[k];
        if (c.plot.empty()) continue;
        auto plot = std::find_if(plots.begin(), plots.end(), [&](const ProbePlot& p) { return p.title == c.plot; });
        if (plot == plots.end()) plot = plots.insert(plots.end(), {c.plot, c.unit, {}});
        plot->curves.push_back({k, label_of(c, columns), c.name.rfind(theory, 0) == 0 || c.name.rfind("expected_", 0) == 0});
    }
    return plots;
}

std::string csv_header(const ProbeColumns& columns) {
    std::vector<std::string> names;
    for (const ProbeColumn& column : columns) names.push_back(column.name);
    return csv_header(names);
}

}  // namespace whorl

// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

/// Weighting of GNSS fixes in the pose graph.
struct GnssUse {
  const char* label;
  const char* gnss;  // scenario setting; empty: no GNSS
};
constexpr GnssUse kGnssUses[] = {
    {"without GNSS", ""},
    {"each axis by its own deviation (eq. 5)", "{weighting: per_axis, huber: 1000}"},
    {"all axes by the worst (eq. 6)", "{weighting: isotropic, huber: 1000}"},
    {"by the square, as released", "{weighting: released, huber: 1000}"},
    {"the worst, a hundred times as much (eq. 7)", "{weighting: isotropic, a: 100, huber: 1000}"},
    {"the worst, with Huber's loss", "{weighting: isotropic, huber: 1}"},
};

/// Twice around the building, with an ascent first and a descent last. The compass gives the initial heading and the
/// first fix the initial position [sec. III-C].
sim::Scenario gnss_flight(const GnssUse& use, std::uint64_t seed, bool quick) {
  const bool used = *use.gnss != '\0';
  return scenario_with(
      "campus", seed,
      {{"vehicles[0].start.position_m", "[-12.5, -10, 1.3]"},
       {"vehicles[0].start.known", used ? "nothing" : "pose"},
       {"vehicles[0].agent.localization",
        fmt::format("{{type: slam, global: {{enabled: true, optimize_every_s: 60, use_gnss: {}{}}}}}", used,
                    used ? fmt::format(", gnss: {}", use.gnss) : "")},
       {"vehicles[0].agent.guidance",
        fmt::format("{{type: waypoints, frame: start, speed_mps: 2, loop: false, waypoints_m: {}}}",
                    "[[0, 0, 2.7], [25, 0, 2.7], [25, 20, 2.7], [0, 20, 2.7], [0, 0, 2.7]" +
                        std::string(quick ? "" : ", [25, 0, 2.7], [25, 20, 2.7], [0, 20, 2.7], [0, 0, 2.7]") +
                        ", [0, 0, 0]]")},
       {"duration_s", quick ? "65" : "110"}});
}

void plot_gnss(Experiment& experiment, const std::vector<std::vector<SlamFlight>>& flights) {
  sim::plot::Figure figure("What the vehicle takes for its place (Fig. 8)", 1);
  figure.set_panel_size(760, 260);
  const char* const axes[] = {"east", "north", "height"};
  for (int axis = 0; axis < 3; ++axis) {
    sim::plot::Panel& panel = figure.add_panel();
    panel.x.label = "time [s]";
    panel.y.label = fmt::format("{} [m]", axes[axis]);
    panel.legend = axis == 0 ? sim::plot::Legend::kOutside : sim::plot::Legend::kNone;
    const SlamFlight& any = flights.front().front();
    std::vector<double> t_s, true_m, gnss_m;
    for (const SlamMoment& m : any.moments) {
      t_s.push_back(m.t_s);
      true_m.push_back(m.p_true_m[axis]);
      gnss_m.push_back(m.p_gnss_m.isZero() ? std::nan("") : m.p_gnss_m[axis]);
    }
    panel.line("truth", t_s, true_m, {.color = 0, .width_px = 3.0, .opacity = 0.5});
    panel.line("GNSS", t_s, gnss_m, {.color = 1, .dash = sim::plot::Dash::kDotted});
    int color = 2;
    for (std::size_t i = 0; i < flights.size(); ++i) {
      if (flights[i].empty()) continue;
      std::vector<double> its_t_s, shown_m;
      for (const SlamMoment& m : flights[i].front().moments) {
        its_t_s.push_back(m.t_s);
        shown_m.push_back(m.t_s < 1.0 ? std::nan("") : m.p_shown_m[axis]);
      }
      panel.line(kGnssUses[i].label, its_t_s, shown_m, {.color = color++});
    }
  }
  experiment.write("gps-weighting.svg", figure);
}

}  // namespace

void gps_weighting(Experiment& experiment) {
  const int seeds = experiment.repetitions(20, 2);
  std::vector<sim::Scenario> scenarios;
  for (const GnssUse& use : kGnssUses) {
    for (int seed = 1; seed <= seeds; ++seed) {
      scenarios.push_back(gnss_flight(use, static_cast<std::uint64_t>(seed), experiment.quick()));
    }
  }
  const std::vector<SlamFlight> all = fly_on_slam(experiment, std::move(scenarios));
  CsvTable csv({"use", "seed", "contact", "lost_s", "shape_m", "tilt_deg", "climb_m", "closures", "false_closures",
                "revisits", "revisits_closed", "largest_correction_m"});
  std::vector<std::vector<SlamFlight>> flights;
  auto next = all.begin();
  int contacts = 0;
  for (const GnssUse& use : kGnssUses) {
    flights.emplace_back(next, next + seeds);
    next += seeds;
    std::vector<double> shape_m, tilt_deg, climb_m;
    ClosureCount closures;
    for (int seed = 1; seed <= seeds; ++seed) {
      const SlamFlight& f = flights.back()[static_cast<std::size_t>(seed - 1)];
      contacts += f.crashed;
      shape_m.push_back(f.graph.rms_m);
      tilt_deg.push_back(f.graph.tilt_deg);
      climb_m.push_back(std::abs(f.graph.climb_m));
      closures.revisits += f.closures.revisits;
      closures.revisits_closed += f.closures.revisits_closed;
      closures.false_ones += f.closures.false_ones;
      csv.row(std::to_string(&use - kGnssUses),
              {static_cast<double>(seed), f.crashed ? 1.0 : 0.0, f.lost_s, f.graph.rms_m, f.graph.tilt_deg,
               f.graph.climb_m, static_cast<double>(f.closures.closed), static_cast<double>(f.closures.false_ones),
               static_cast<double>(f.closures.revisits), static_cast<double>(f.closures.revisits_closed),
               f.correction.largest_m});
    }
    const std::string note = fmt::format(
        "median; shape of the way off by {:.3f} m, leaning by {:.2f} deg; {} of {} revisits closed, {} falsely",
        median_of(shape_m), median_of(tilt_deg), closures.revisits_closed, closures.revisits, closures.false_ones);
    const std::string what = fmt::format("{}: height at landing [m]", use.label);
    const bool judged = *use.gnss == '\0' || &use == &kGnssUses[5];
    if (judged)
      experiment.at_most(what, median_of(climb_m), 0.1, 2, note);
    else
      experiment.row({what, short_number(median_of(climb_m), 2), Verdict::kNotJudged, note, median_of(climb_m)});
  }
  std::vector<double> gnss_climb_m;
  for (const SlamFlight& f : flights.front()) {
    std::vector<Vector3> fixes_m;
    for (const SlamMoment& m : f.moments) {
      if (!m.p_gnss_m.isZero()) fixes_m.push_back(m.p_gnss_m);
    }
    if (fixes_m.empty()) continue;
    const double climb_m = f.moments.back().p_true_m.z() - f.moments.front().p_true_m.z();
    gnss_climb_m.push_back(std::abs(fixes_m.back().z() - fixes_m.front().z() - climb_m));
  }
  experiment.row({"GNSS itself: height at landing [m]", short_number(median_of(gnss_climb_m), 2),
                  Verdict::kOtherConditions, "median; the receiver's model drifts by 2 m in a minute",
                  median_of(gnss_climb_m)});
  experiment.at_most("contacts", contacts, 0.0, 1, fmt::format("{} flights", all.size()));
  experiment.write("flights.csv", csv);
  plot_gnss(experiment, flights);
}

}  // namespace swiftlet::tools

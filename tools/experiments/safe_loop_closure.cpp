// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "experiments.hpp"
#include "parallel.hpp"
#include "slam_flights.hpp"
#include "swiftlet/core/slam/correction_blend.hpp"
#include "swiftlet/sim/plot/plot.hpp"

namespace swiftlet::tools {
namespace {

struct ShownBy {
  BlendForm form;
  const char* name;   // value in the scenario
  const char* label;  // name in tables
};
constexpr ShownBy kBlendForms[] = {{BlendForm::kNone, "none", "at once"},
                                   {BlendForm::kPrinted, "printed", "eq. 2 as printed"},
                                   {BlendForm::kReleased, "released", "eq. 2 as released"},
                                   {BlendForm::kLimited, "limited", "limited"}};
const ShownBy& kDefaultForm = kBlendForms[3];

/// Blend of a correction of 1 m, and of a second one of 1 m that begins when half of the first is shown.
struct BlendCourse {
  std::vector<double> t_s, left;  // remaining part of the first [m]
  double at_once_m = 0.0, at_the_end_m = 0.0;
  double speed_mps = 0.0, acceleration_mps2 = 0.0;  // largest between start and end
  double whole_s = 0.0;
  double kink_mps = 0.0;  // jump of the speed when the second begins
};

Pose displaced(double x_m) {
  Pose T = Pose::Identity();
  T.translation().x() = x_m;
  return T;
}

BlendCourse course_of(BlendForm form) {
  constexpr TimeNs kStep = 1'000'000;
  constexpr double kStep_s = 1e-3;
  CorrectionBlendConfig config;
  config.form = form;
  BlendCourse course;
  CorrectionBlend blend(config);
  blend.reset(Pose::Identity());
  blend.head_for(0, displaced(1.0), Vector3::Zero());
  double x_m = blend.advance(0).translation().x(), v_mps = 0.0;
  course.at_once_m = x_m;
  bool v_known = false;
  TimeNs half = 0;
  for (TimeNs t = 0;; t += kStep) {
    course.t_s.push_back(to_seconds(t));
    course.left.push_back(1.0 - x_m);
    if (half == 0 && x_m >= 0.5) half = t;
    if (blend.is_done()) break;
    const double next_m = blend.advance(t + kStep).translation().x();
    if (blend.is_done()) {
      course.at_the_end_m = next_m - x_m;
      course.whole_s = to_seconds(t + kStep);
    } else {
      const double speed_mps = (next_m - x_m) / kStep_s;
      course.speed_mps = std::max(course.speed_mps, speed_mps);
      if (v_known) course.acceleration_mps2 = std::max(course.acceleration_mps2, std::abs(speed_mps - v_mps) / kStep_s);
      v_mps = speed_mps;
      v_known = true;
    }
    x_m = next_m;
  }
  CorrectionBlend twice(config);
  twice.reset(Pose::Identity());
  twice.head_for(0, displaced(1.0), Vector3::Zero());
  if (half > 2 * kStep) {
    const double before_m = twice.advance(half - kStep).translation().x();
    const double now_m = twice.advance(half).translation().x();
    twice.head_for(half, displaced(2.0), Vector3::Zero());
    const double from_m = twice.advance(half).translation().x();
    const double after_m = twice.advance(half + kStep).translation().x();
    course.kink_mps = std::abs((after_m - from_m) - (now_m - before_m)) / kStep_s;
  }
  return course;
}

sim::Scenario twice_around(const ShownBy& form, std::uint64_t seed) {
  return scenario_with("campus_closure", seed, {{"vehicles[0].agent.localization.global.blend.form", form.name}});
}

/// Once around with a poor GNSS, then hover. The correction of about 1 m by the first optimization of the round, the
/// most aggressive one [sec. V-C], arrives during the hover. The path between the building and the trees keeps clear of
/// both by more than the error of the first fix.
sim::Scenario once_around(const ShownBy& form, std::uint64_t seed) {
  return scenario_with(
      "campus", seed,
      {{"vehicles[0].start.known", "nothing"},
       {"vehicles[0].start.position_m", "[-11.5, -8.7, 9]"},
       {"vehicles[0].agent.localization",
        fmt::format("{{type: slam, global: {{enabled: true, latency_s: 22, optimize_every_s: 45, gnss: "
                    "{{huber: 1000}}, blend: {{form: {}}}}}}}",
                    form.name)},
       {"vehicles[0].agent.guidance.waypoints_m",
        "[[11.5, -8.7, 9], [11.5, 8.7, 10], [-11.5, 8.7, 10], [-11.5, -8.7, 9], [-3, -8.7, 9]]"},
       {"vehicles[0].agent.guidance.loop", "false"},
       {"metrics.stop_when_done", "false"},
       {"duration_s", "90"}});
}

struct FormFlights {
  const ShownBy* form;
  bool hovers;
  std::vector<SlamFlight> flights;
};

double largest_of(const FormFlights& group, double CorrectionCourse::*value) {
  double worst = 0.0;
  for (const SlamFlight& f : group.flights) worst = std::max(worst, f.correction.*value);
  return worst;
}
double median_over_flights(const FormFlights& group, double SlamFlight::*value) {
  std::vector<double> values;
  for (const SlamFlight& f : group.flights) values.push_back(f.*value);
  return median_of(values);
}

void tell_courses(Experiment& experiment) {
  CsvTable csv({"form", "at_once_m", "at_the_end_m", "speed_mps", "acceleration_mps2", "whole_s", "kink_mps"});
  sim::plot::Figure figure("A correction of 1 m, how much of it is not shown yet (Fig. 2)", 1);
  sim::plot::Panel& panel = figure.add_panel();
  panel.x.label = "time since it was learned [s]";
  panel.y.label = "not shown yet [m]";
  panel.x.max = 9.0;
  for (const ShownBy& form : kBlendForms) {
    const BlendCourse c = course_of(form.form);
    csv.row(form.name, {c.at_once_m, c.at_the_end_m, c.speed_mps, c.acceleration_mps2, c.whole_s, c.kink_mps});
    if (form.form == BlendForm::kNone) continue;
    std::vector<double> t_s, left_m;  // 1 kHz is more than a plot needs
    for (std::size_t i = 0; i < c.t_s.size(); i += 50) {
      t_s.push_back(c.t_s[i]);
      left_m.push_back(c.left[i]);
    }
    panel.line(form.label, t_s, left_m);
    const std::string note = fmt::format(
        "{:.2f} % more in the end; at most {:.3f} m/s and {:.3f} m/s^2 in between; speed jumps by "
        "{:.3f} m/s when a second one of 1 m comes half-way",
        100.0 * c.at_the_end_m, c.speed_mps, c.acceleration_mps2, c.kink_mps);
    const std::string what = fmt::format("{}: of a correction of 1 m at once [%]", form.label);
    if (&form != &kDefaultForm) {
      experiment.row({what, short_number(100.0 * c.at_once_m, 3), Verdict::kNotJudged, note, 100.0 * c.at_once_m});
      continue;
    }
    experiment.at_most(what, 100.0 * c.at_once_m, 0.001, 3, note);
    experiment.within("time over which a correction is spread [s]", c.whole_s, 0.15, 2, "1 m, the limited form");
    experiment.at_most("limited: speed, 1 m [m/s]", c.speed_mps, 0.25, 3);
    experiment.at_most("limited: acceleration, 1 m [m/s^2]", c.acceleration_mps2, 0.1, 3);
    experiment.at_most("limited: jump of the speed at a second correction [m/s]", c.kink_mps, 0.001, 2);
  }
  experiment.write("courses.csv", csv);
  experiment.write("safe-loop-closure-blend.svg", figure);
}

/// Position error while the first large correction is shown: Fig. 1, against truth.
void plot_rounds(Experiment& experiment, const std::vector<FormFlights>& groups) {
  sim::plot::Figure figure("Twice around the building: what the vehicle takes for its place (Fig. 1)", 1);
  figure.set_panel_size(760, 300);
  sim::plot::Panel& height = figure.add_panel("height");
  sim::plot::Panel& place = figure.add_panel("horizontally");
  for (sim::plot::Panel* panel : {&height, &place}) panel->x.label = "time [s]";
  height.y.label = "error of the height [m]";
  place.y.label = "error [m]";
  int color = 0;
  for (const FormFlights& group : groups) {
    if (group.hovers || group.flights.empty()) continue;
    std::vector<double> t_s, height_m, off_m;
    for (const SlamMoment& m : group.flights.front().moments) {
      t_s.push_back(m.t_s);
      const Vector3 off = m.p_shown_m - m.p_true_m;
      height_m.push_back(off.z());
      off_m.push_back(off.head<2>().norm());
    }
    height.line(group.form->label, t_s, height_m, {.color = color});
    place.line(group.form->label, t_s, off_m, {.color = color});
    ++color;
  }
  experiment.write("safe-loop-closure.svg", figure);
}

}  // namespace

void safe_loop_closure(Experiment& experiment) {
  tell_courses(experiment);
  const int seeds = experiment.repetitions(20, 1);
  std::vector<FormFlights> groups;
  std::vector<sim::Scenario> scenarios;
  std::vector<int> counts;
  for (const bool hovers : {false, true}) {
    for (const ShownBy& form : kBlendForms) {
      // The default gets more flights, to bound the probability of a contact.
      counts.push_back(!hovers && &form == &kDefaultForm && !experiment.quick() ? 5 * seeds : seeds);
      groups.push_back({&form, hovers, {}});
      for (int seed = 1; seed <= counts.back(); ++seed) {
        scenarios.push_back((hovers ? once_around : twice_around)(form, static_cast<std::uint64_t>(seed)));
      }
    }
  }
  const std::vector<SlamFlight> all = fly_on_slam(experiment, std::move(scenarios));
  auto next = all.begin();
  for (std::size_t i = 0; i < groups.size(); ++i) {
    groups[i].flights.assign(next, next + counts[i]);
    next += counts[i];
  }

  CsvTable csv({"flight", "form", "seed", "contact", "corrections", "largest_m", "step_m", "speed_mps",
                "acceleration_mps2", "rms_m", "rms_local_after_m", "rms_after_m", "true_speed_after_mps",
                "true_acceleration_after_mps2", "closures", "false_closures", "revisits", "revisits_closed"});
  int contacts = 0, flights = 0, false_closures = 0;
  for (const FormFlights& group : groups) {
    for (std::size_t seed = 0; seed < group.flights.size(); ++seed) {
      const SlamFlight& f = group.flights[seed];
      const CorrectionCourse& c = f.correction;
      ++flights;
      contacts += f.crashed;
      false_closures += f.closures.false_ones;
      csv.row(group.hovers ? "hovers" : "laps",
              {static_cast<double>(group.form->form), static_cast<double>(seed + 1), f.crashed ? 1.0 : 0.0,
               static_cast<double>(c.count), c.largest_m, c.step_m, c.speed_mps, c.acceleration_mps2, f.rms_m,
               f.rms_local_after_m, f.rms_after_m, f.speed_after_mps, f.acceleration_after_mps2,
               static_cast<double>(f.closures.closed), static_cast<double>(f.closures.false_ones),
               static_cast<double>(f.closures.revisits), static_cast<double>(f.closures.revisits_closed)});
    }
  }
  experiment.write("flights.csv", csv);

  for (const FormFlights& group : groups) {
    const std::string note = fmt::format(
        "{} flights; corrections of up to {:.2f} m; at most {:.3f} m/s and {:.3f} m/s^2 otherwise",
        group.flights.size(), largest_of(group, &CorrectionCourse::largest_m),
        largest_of(group, &CorrectionCourse::speed_mps), largest_of(group, &CorrectionCourse::acceleration_mps2));
    if (group.hovers) {
      const double speed_mps = median_over_flights(group, &SlamFlight::speed_after_mps);
      experiment.row({fmt::format("hovering, {}: the vehicle's fastest motion [m/s]", group.form->label),
                      short_number(speed_mps, 2), Verdict::kNotJudged,
                      fmt::format("median; acceleration {:.2f} m/s^2; {}",
                                  median_over_flights(group, &SlamFlight::acceleration_after_mps2), note),
                      speed_mps});
      continue;
    }
    const double step_m = largest_of(group, &CorrectionCourse::step_m);
    if (group.form == &kDefaultForm) {
      experiment.claim("steps in the pose when a loop is closed", fmt::format("at most {:.1e} m", step_m),
                       step_m < 1e-5, note);
      experiment.at_most("limited: speed of the correction in flight [m/s]",
                         largest_of(group, &CorrectionCourse::speed_mps), 0.25, 3);
      experiment.at_most("limited: acceleration of the correction in flight [m/s^2]",
                         largest_of(group, &CorrectionCourse::acceleration_mps2), 0.1, 3);
    } else {
      experiment.row({fmt::format("{}: largest step of the pose [m]", group.form->label), short_number(step_m, 3),
                      Verdict::kNotJudged, note, step_m});
    }
  }
  experiment.at_most("contacts", contacts, 0.0, 1, fmt::format("{} flights", flights));
  experiment.at_most("false closures", false_closures, 0.0, 1);
  plot_rounds(experiment, groups);
}

}  // namespace swiftlet::tools

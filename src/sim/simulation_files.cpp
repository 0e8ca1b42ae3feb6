#include <fmt/format.h>

#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "io/csv.h"
#include "io/json.h"
#include "piste/math/units.h"
#include "piste/sim/simulation.h"

namespace piste {
namespace {

constexpr int kTimeDecimals = 6, kPlaceDecimals = 10, kMetreDecimals = 4, kVelocityDecimals = 4, kAngleDecimals = 5,
              kGateDecimals = 7;

// Adds the columns of three axes.
void add_triad(std::vector<CsvColumn>& columns, std::string_view before, std::array<std::string_view, 3> axes,
               std::string_view after, int decimals) {
  for (const std::string_view axis : axes) columns.push_back({fmt::format("{}{}{}", before, axis, after), decimals});
}

constexpr std::array<std::string_view, 3> kBody{"x", "y", "z"}, kLocal{"north", "east", "down"},
    kEuler{"roll", "pitch", "heading"};

void append(std::vector<double>& row, const Vector3d& v, double factor = 1) {
  for (const double value : v) row.push_back(factor * value);
}

void append(std::vector<double>& row, const Geodetic& place) {
  row.insert(row.end(), {kDegreesPerRadian * place.latitude, kDegreesPerRadian * place.longitude, place.height});
}

void add_place(std::vector<CsvColumn>& columns) {
  columns.push_back({"latitude_deg", kPlaceDecimals});
  columns.push_back({"longitude_deg", kPlaceDecimals});
  columns.push_back({"height_m", kMetreDecimals});
}

std::string vector_json(const Vector3d& v, double factor = 1) {
  const Vector3d u = (factor * v).array() + 0.0;  // no −0
  return json::numbers(u, 9);
}

std::string matrix_json(const Matrix3d& m) {
  return fmt::format("[{}, {}, {}]", vector_json(m.row(0)), vector_json(m.row(1)), vector_json(m.row(2)));
}

// A mean over the rows of a phase, or null if it has none.
std::string phase_json(const PhaseDraw& phase, const Vector3d& mean, double factor) {
  return phase.rows > 0 ? vector_json(mean, factor) : "null";
}

std::string drift_json(const std::optional<GaussMarkov>& drift, double factor) {
  if (!drift) return "null";
  return fmt::format(R"({{"sigma": {}, "correlation_time_s": {:.9g}}})", vector_json(drift->sigma, factor),
                     drift->correlation_time);
}

std::string triad_json(const TriadDraw& draw, const TriadTruth& given, const std::string& unit, double factor) {
  return json::object({{"bias_" + unit, vector_json(draw.bias, factor)},
                       {"scale_ppm", vector_json(draw.scale, 1e6)},
                       {"misalignment", matrix_json(draw.misalignment)},
                       {"drift_first_" + unit, vector_json(draw.drift_first, factor)},
                       {"drift_last_" + unit, vector_json(draw.drift_last, factor)},
                       {"drift_mean_" + unit, vector_json(draw.drift_mean, factor)},
                       {"drift_rms_" + unit, vector_json(draw.drift_rms, factor)},
                       {"drift_before_" + unit, phase_json(draw.before, draw.before.drift, factor)},
                       {"drift_run_" + unit, phase_json(draw.run, draw.run.drift, factor)},
                       {"drift_after_" + unit, phase_json(draw.after, draw.after.drift, factor)},
                       {"warm_up_" + unit, vector_json(given.warm_up, factor)},
                       {"warm_up_time_s", json::number(given.warm_up_time, 9)},
                       {"mean_before_" + unit, phase_json(draw.before, draw.before.mean, factor)},
                       {"mean_after_" + unit, phase_json(draw.after, draw.after.mean, factor)},
                       {"run_mean_" + unit, vector_json(draw.run.mean, factor)},
                       {"run_rms_" + unit, vector_json(draw.run.rms, factor)},
                       {"bias_scale_correlation", vector_json(bias_scale_correlation(draw))},
                       {"clipped_rows", fmt::format("{}", draw.clipped)}},
                      3);
}

std::string imu_json(const Scenario& scenario, const ImuSetup& setup, const SimulatedImu& imu) {
  json::Members arms;
  for (const GnssSetup& gnss : scenario.gnss) arms.emplace_back(gnss.name, vector_json(lever_arm(setup, gnss)));
  json::Members members{{"sensor", json::string(setup.sensor.name)},
                        {"boresight_deg", vector_json(to_euler(setup.q_rb), kDegreesPerRadian)},
                        {"position_m", vector_json(setup.p_rb_r)},
                        {"lever_arm_m", json::object(arms, 3)},
                        {"clock_offset_s", json::number(setup.clock_offset, 9)},
                        {"clock_drift_ppm", json::number(1e6 * setup.clock_drift, 9)},
                        {"gyro", triad_json(imu.gyro, setup.gyro, "deg_s", kDegreesPerRadian)},
                        {"accel", triad_json(imu.accel, setup.accel, "m_s2", 1)}};
  if (setup.sensor.gyro_g_sensitivity.value_or(0) > 0) {
    members.emplace_back("g_sensitivity_deg_s_g",
                         matrix_json(kDegreesPerRadian * kStandardGravity * imu.g_sensitivity));
  }
  if (setup.magnetic_field) {
    members.emplace_back("magnetometer",
                         json::object({{"field_uT", vector_json(*setup.magnetic_field)},
                                       {"hard_iron_uT", vector_json(imu.hard_iron)},
                                       {"soft_iron", matrix_json(imu.soft_iron)},
                                       {"noise_uT", json::number(setup.magnetometer.sigma, 9)},
                                       {"disturbance_uT", drift_json(setup.magnetometer.disturbance, 1)}},
                                      3));
  }
  return json::object(members, 2);
}

std::string gnss_json(const GnssSetup& setup) {
  json::Members members{{"lever_arm_m", vector_json(setup.p_ra_r)},
                        {"position_noise_m", vector_json(setup.position_noise)},
                        {"position_drift_m", drift_json(setup.position_drift, 1)},
                        {"velocity_noise_m_s", vector_json(setup.velocity_noise)},
                        {"delay_s", json::number(setup.delay, 9)}};
  if (setup.velocity_delay) members.emplace_back("velocity_delay_s", json::number(*setup.velocity_delay, 9));
  return json::object(members, 2);
}

std::string attitude_json(const AttitudeSetup& setup) {
  json::Members members{{"noise_deg", vector_json(setup.noise, kDegreesPerRadian)},
                        {"drift_deg", drift_json(setup.drift, kDegreesPerRadian)}};
  if (setup.delay != 0) members.emplace_back("delay_s", json::number(setup.delay, 9));
  return json::object(members, 2);
}

std::string gate_name(std::size_t i) { return fmt::format("gate_{}", i + 1); }

// When a body passes each gate.
std::string gates_json(const Truth& body) {
  json::Members times;
  const std::vector<CourseGate> gates = body.gates();
  for (std::size_t i = 0; i < gates.size(); ++i) {
    const CourseGate& gate = gates[i];
    const double time = crossing_time(body, gate.place, {std::cos(gate.heading), std::sin(gate.heading), 0},
                                      body.start_time() + gate.about);
    times.emplace_back(gate_name(i), fmt::format("{:.9f}", time));
  }
  return json::object(times, 1);
}

}  // namespace

std::string imu_csv(const ImuRecording& recording) {
  std::vector<CsvColumn> columns{{"time_s", kTimeDecimals}};
  add_triad(columns, recording.increments ? "dtheta_" : "gyro_", kBody, recording.increments ? "_rad" : "_rad_s",
            recording.increments ? 9 : 7);
  add_triad(columns, recording.increments ? "dvel_" : "accel_", kBody, recording.increments ? "_m_s" : "_m_s2",
            recording.increments ? 8 : 6);
  const bool magnetic = !recording.magnetic.empty();
  if (magnetic) add_triad(columns, "mag_", kBody, "_uT", 3);

  CsvWriter csv(columns);
  std::vector<double> row;
  for (std::size_t k = 0; k < recording.time.size(); ++k) {
    row = {recording.time[k]};
    append(row, recording.gyro[k]);
    append(row, recording.accel[k]);
    if (magnetic) append(row, recording.magnetic[k]);
    csv.row(row);
  }
  return std::move(csv).text();
}

std::string gnss_csv(const GnssRecording& recording) {
  const bool velocity = !recording.fixes.empty() && recording.fixes.front().velocity.has_value();
  std::vector<CsvColumn> columns{{"time_s", kTimeDecimals}};
  add_place(columns);
  add_triad(columns, "sigma_", kLocal, "_m", kMetreDecimals);
  if (velocity) {
    add_triad(columns, "velocity_", kLocal, "_m_s", kVelocityDecimals);
    add_triad(columns, "sigma_velocity_", kLocal, "_m_s", kVelocityDecimals);
  }
  CsvWriter csv(columns);
  std::vector<double> row;
  for (const GeodeticFix& fix : recording.fixes) {
    row = {fix.time};
    append(row, fix.position);
    append(row, fix.sigma_position);
    if (fix.velocity) {
      append(row, fix.velocity->value);
      append(row, fix.velocity->sigma);
    }
    csv.row(row);
  }
  return std::move(csv).text();
}

std::string attitude_csv(const AttitudeRecording& recording) {
  std::vector<CsvColumn> columns{{"time_s", kTimeDecimals}};
  add_triad(columns, "", kEuler, "_deg", kAngleDecimals);
  add_triad(columns, "sigma_", kEuler, "_deg", kAngleDecimals);
  CsvWriter csv(columns);
  std::vector<double> row;
  for (const EulerFix& fix : recording.fixes) {
    row = {fix.time};
    append(row, fix.angles, kDegreesPerRadian);
    append(row, fix.sigma, kDegreesPerRadian);
    csv.row(row);
  }
  return std::move(csv).text();
}

std::string speed_csv(const FixRecording<SpeedFix>& recording) {
  CsvWriter csv({{"time_s", kTimeDecimals}, {"speed_m_s", kVelocityDecimals}, {"sigma_speed_m_s", kVelocityDecimals}});
  for (const SpeedFix& fix : recording.fixes) csv.row(std::vector{fix.time, fix.speed, fix.sigma});
  return std::move(csv).text();
}

std::string height_csv(const FixRecording<HeightFix>& recording) {
  CsvWriter csv({{"time_s", kTimeDecimals}, {"height_m", kMetreDecimals}, {"sigma_height_m", kMetreDecimals}});
  for (const HeightFix& fix : recording.fixes) csv.row(std::vector{fix.time, fix.height, fix.sigma});
  return std::move(csv).text();
}

std::string heading_csv(const FixRecording<HeadingFix>& recording) {
  const bool pitch = !recording.fixes.empty() && recording.fixes.front().pitch.has_value();
  std::vector<CsvColumn> columns{
      {"time_s", kTimeDecimals}, {"heading_deg", kAngleDecimals}, {"sigma_heading_deg", kAngleDecimals}};
  if (pitch) columns.insert(columns.end(), {{"pitch_deg", kAngleDecimals}, {"sigma_pitch_deg", kAngleDecimals}});
  CsvWriter csv(columns);
  for (const HeadingFix& fix : recording.fixes) {
    std::vector<double> row{fix.time, kDegreesPerRadian * fix.heading, kDegreesPerRadian * fix.sigma};
    if (pitch) row.insert(row.end(), {kDegreesPerRadian * *fix.pitch, kDegreesPerRadian * fix.sigma_pitch});
    csv.row(row);
  }
  return std::move(csv).text();
}

std::string truth_csv(const Truth& body, const std::vector<double>& gps_time, std::size_t every) {
  std::vector<CsvColumn> columns{{"time_s", kTimeDecimals}};
  add_place(columns);
  add_triad(columns, "velocity_", kLocal, "_m_s", kVelocityDecimals + 1);
  add_triad(columns, "", kEuler, "_deg", kAngleDecimals);
  CsvWriter csv(columns);
  std::vector<double> row;
  for (std::size_t k = 0; k < gps_time.size(); k += every) {
    const TruthState state = body.at(gps_time[k]);
    const Matrix3d R_nw = body.world().rotation_wn(state.p_wb).transpose();
    row = {state.time};
    append(row, body.world().to_geodetic(state.p_wb));
    append(row, R_nw * state.v_wb);
    append(row, to_euler(Quaterniond(R_nw) * state.q_wb), kDegreesPerRadian);
    csv.row(row);
  }
  return std::move(csv).text();
}

std::string gates_csv(const Truth& body) {
  std::string text = "name,latitude_deg,longitude_deg,heading_deg\n";
  const std::vector<CourseGate> gates = body.gates();
  for (std::size_t i = 0; i < gates.size(); ++i) {
    const CourseGate& gate = gates[i];
    const Geodetic place = body.world().to_geodetic(gate.place);
    const Vector3d along =
        body.world().rotation_wn(gate.place).transpose() * Vector3d(std::cos(gate.heading), std::sin(gate.heading), 0);
    text += gate_name(i);
    for (const auto& [value, decimals] :
         {std::pair{kDegreesPerRadian * place.latitude, kPlaceDecimals},
          std::pair{kDegreesPerRadian * place.longitude, kPlaceDecimals},
          std::pair{kDegreesPerRadian * std::atan2(along.y(), along.x()), kGateDecimals}}) {
      text += ',';
      append_fixed(text, value, decimals);
    }
    text += '\n';
  }
  return text;
}

std::string truth_json(const Scenario& scenario, const Simulation& simulation, std::uint64_t seed) {
  json::Members imus, gnss, attitude, aids;
  for (std::size_t i = 0; i < scenario.imus.size(); ++i) {
    imus.emplace_back(scenario.imus[i].name, imu_json(scenario, scenario.imus[i], simulation.imus[i]));
  }
  for (const GnssSetup& setup : scenario.gnss) gnss.emplace_back(setup.name, gnss_json(setup));
  for (const AttitudeSetup& setup : scenario.attitude) attitude.emplace_back(setup.name, attitude_json(setup));
  const AidSetups& others = scenario.aids;
  if (others.odometer) {
    aids.emplace_back("odometer", json::object({{"scale_ppm", json::number(1e6 * simulation.aids.odometer_scale, 9)},
                                                {"noise_m_s", json::number(others.odometer->errors.sigma, 9)}},
                                               2));
  }
  if (others.barometer) {
    aids.emplace_back("barometer",
                      json::object({{"offset_first_m", json::number(simulation.aids.barometer_offset.front(), 9)},
                                    {"offset_last_m", json::number(simulation.aids.barometer_offset.back(), 9)},
                                    {"noise_m", json::number(others.barometer->errors.sigma, 9)}},
                                   2));
  }
  if (others.heading) {
    aids.emplace_back(
        "heading", json::object({{"noise_deg", json::number(kDegreesPerRadian * others.heading->errors.sigma, 9)}}, 2));
  }
  if (others.vehicle) {
    const ImuSetup& body = scenario.imus.front();
    const TrueMounting mounting = true_mounting(scenario.q_tr, body.q_rb, body.p_rb_r);
    aids.emplace_back("vehicle",
                      json::object({{"mounting_deg", vector_json(to_euler(mounting.q_vb), kDegreesPerRadian)},
                                    {"contact_m", vector_json(mounting.contact)}},
                                   2));
  }
  const Interval run = simulation.plate.under_way();
  const Geodetic& origin = scenario.origin;
  json::Members members{
      {"simulated", "true"},
      {"seed", fmt::format("{}", seed)},
      {"convention", json::string("measured = (1 + scale) M true + bias + drift + noise; boresight is R_rb, b into r")},
      {"body", json::string(scenario.imus.front().name)},
      {"origin", fmt::format(R"({{"latitude_deg": {:.10g}, "longitude_deg": {:.10g}, "height_m": {:.6g}}})",
                             kDegreesPerRadian * origin.latitude, kDegreesPerRadian * origin.longitude, origin.height)},
      {"run_s", json::numbers(std::array{run.start, run.end}, 9)},
      {"imus", json::object(imus, 1)},
      {"gnss", json::object(gnss, 1)},
      {"attitude", json::object(attitude, 1)}};
  if (!aids.empty()) members.emplace_back("others", json::object(aids, 1));
  if (scenario.motion.course) members.emplace_back("gates_time_s", gates_json(simulation.bodies.front()));
  return json::object(members, 0) + "\n";
}

}  // namespace piste

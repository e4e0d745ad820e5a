#include "palpate/rig/rig.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"

namespace palpate::rig {
namespace {

Vector3 vector(Random& random) { return {random.normal(), random.normal(), random.normal()}; }
Quaternion rotation(Random& random) { return so3_exp(vector(random)); }
Eigen::MatrixXd covariance(Random& random, Eigen::Index n) {
  Eigen::MatrixXd m(n, n);
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = 1e-4 * random.normal();
  return m * m.transpose();
}
Provenance provenance(const char* method) {
  return {"2026-02-03T04:05:06Z", "0123456789abcdef", method, 0.123456789012345};
}

// As a file has it, which lacks the three parameters that only a rational lens has.
Eigen::MatrixXd of_five_coefficients(const Eigen::MatrixXd& filed) {
  const Eigen::Index rest = filed.rows() - 9, size = filed.rows() + 3;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; i < filed.rows(); ++i)
    for (Eigen::Index j = 0; j < filed.rows(); ++j) all(i < 9 ? i : i + 3, j < 9 ? j : j + 3) = filed(i, j);
  EXPECT_EQ(rest % 3, 0);
  return all;
}

Rig full_rig() {
  Random random(1, "rig");
  Rig rig;
  rig.name = "bench \"two\"";
  rig.nominal_arm.lengths = {0.2159, 0.17};
  for (auto* leds : {&rig.tip_marker_leds, &rig.camera_marker_leds, &rig.pointer_leds})
    for (int i = 0; i < 4; ++i) leds->push_back(vector(random));
  rig.tip_pivot = PivotCalibration{vector(random), covariance(random, 3), provenance("algebraic")};
  rig.pointer_pivot = PivotCalibration{vector(random), covariance(random, 3), provenance("robust")};
  ArmCalibration arm;
  arm.model.lengths = {0.21, 0.1699999999};
  arm.correction = {Vector3(1.01, 0.99, 1.0 / 0.97), vector(random)};
  arm.X_world_base = {rotation(random), vector(random)};
  arm.tip_in_marker = vector(random);
  arm.R_tip_marker = rotation(random);
  arm.gimbal_gain = Vector3(1.002, 0.993, 1.0);
  arm.gimbal_offset = vector(random);
  arm.covariance = covariance(random, 15);
  arm.rest_readings = 0.01 * vector(random);
  arm.held_out_mean = 0.00032;
  arm.from = provenance("joint");
  rig.arm = arm;
  CameraCalibration camera;
  camera.model.fx = 561.23456789, camera.model.distortion = {-0.28, 0.09, 0.001, -0.0005, 1e-17};
  camera.covariance = of_five_coefficients(covariance(random, 9));
  camera.from = provenance("chessboard");
  rig.camera = camera;
  rig.hand_eye =
      HandEyeCalibration{{rotation(random), vector(random)}, covariance(random, 6), provenance("joint")};
  rig.right_camera = camera;
  rig.right_camera->model.fx = 559.87654321, rig.right_camera->encoding = device::Encoding::srgb;
  rig.right_hand_eye =
      HandEyeCalibration{{rotation(random), vector(random)}, covariance(random, 6), provenance("joint")};
  rig.headset = HeadsetCalibration{
      {rotation(random), vector(random)}, covariance(random, 6), 0.0123, 0.0004, provenance("joint")};
  rig.light = device::RoomLight{vector(random), 0.2, 0.7, 0.3};
  rig.objects.push_back({"head", "head one.stl", 0.001, rotation(random), vector(random)});
  rig.objects.push_back({"vise", "/meshes/vise.ply", 1.0, rotation(random), vector(random)});
  rig.delays = DelayCalibration{0.0101, -0.0302, 1e-4, 2e-4, provenance("joint")};
  rig.surfaces.push_back({"table",
                          {rotation(random), vector(random)},
                          0.75,
                          1.0,
                          covariance(random, 8),
                          provenance("rectangle")});
  rig.surfaces.back().touch = {0.00041, 14.5};
  rig.surfaces.push_back(
      {"wall", {rotation(random), vector(random)}, 0.75, 0.6, {}, provenance("rectangle")});
  for (int i = 0; i < 5; ++i)
    rig.landmarks.push_back({{vector(random)}, covariance(random, 3), vector(random).normalized(), 0.008});
  rig.registration_covariance = of_five_coefficients(covariance(random, 9 + 6 + 3 * 5));
  rig.landmarks_from = provenance("head-motion");
  return rig;
}

// All numbers of a rig, in one order; two rigs are the same where these agree.
std::vector<double> numbers(const Rig& rig) {
  std::vector<double> all;
  const auto add = [&](const auto& matrix) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      for (Eigen::Index i = 0; i < matrix.rows(); ++i) all.push_back(matrix(i, j));
  };
  const auto add_pose = [&](const auto& X) { add(X.rotation.coeffs()), add(X.translation); };
  const auto add_from = [&](const Provenance& from) { all.push_back(from.rms_mm); };
  add(Eigen::Vector2d(rig.nominal_arm.lengths.l1, rig.nominal_arm.lengths.l2));
  for (const auto* leds : {&rig.tip_marker_leds, &rig.camera_marker_leds, &rig.pointer_leds})
    for (const auto& led : *leds) add(led);
  for (const auto* pivot : {&rig.tip_pivot, &rig.pointer_pivot})
    if (*pivot) add((*pivot)->tip_in_marker), add((*pivot)->covariance), add_from((*pivot)->from);
  if (const auto& arm = rig.arm) {
    add(Eigen::Vector2d(arm->model.lengths.l1, arm->model.lengths.l2)), add(arm->correction.gain),
        add(arm->correction.offset);
    add_pose(arm->X_world_base), add(arm->tip_in_marker), add(arm->R_tip_marker.coeffs()),
        add(arm->gimbal_gain);
    add(arm->gimbal_offset), add(arm->covariance), add(arm->rest_readings), all.push_back(arm->held_out_mean);
    add_from(arm->from);
  }
  for (const auto* camera : {&rig.camera, &rig.right_camera}) {
    const auto& c = *camera;
    if (!c) continue;
    add(Eigen::Vector4d(c->model.fx, c->model.fy, c->model.cx, c->model.cy)), add(c->covariance),
        add_from(c->from);
    for (double d : c->model.distortion) all.push_back(d);
    all.push_back(c->model.width), all.push_back(c->model.height);
    all.push_back(static_cast<double>(c->encoding));
  }
  for (const auto* hand_eye : {&rig.hand_eye, &rig.right_hand_eye})
    if (const auto& h = *hand_eye) add_pose(h->X_marker_camera), add(h->covariance), add_from(h->from);
  if (const auto& h = rig.headset)
    add_pose(h->X_eyes_camera), add(h->covariance), add(Eigen::Vector2d(h->delay_s, h->delay_std_s)),
        add_from(h->from);
  if (const auto& l = rig.light) add(l->lamp), add(Vector3(l->lamp_radius, l->key, l->ambient));
  for (const auto& o : rig.objects)
    add(o.rotation.coeffs()), add(o.position), all.push_back(o.metres_per_unit);
  if (const auto& d = rig.delays)
    add(Eigen::Vector4d(d->tracker_after_arm_s, d->camera_after_tracker_s, d->tracker_std_s,
                        d->camera_std_s)),
        add_from(d->from);
  for (const auto& s : rig.surfaces)
    add_pose(s.X_world_rectangle), add(Eigen::Vector2d(s.width, s.height)), add(s.covariance),
        add(Eigen::Vector2d(s.touch.sd, s.touch.freedoms)), add_from(s.from);
  for (const auto& l : rig.landmarks)
    add(l.place.m), add(l.covariance), add(l.normal), all.push_back(l.diameter);
  add(rig.registration_covariance);
  add_from(rig.landmarks_from);
  return all;
}

void expect_same(const Rig& a, const Rig& b) {
  const auto x = numbers(a), y = numbers(b);
  ASSERT_EQ(x.size(), y.size());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], y[i], 1e-12 * std::abs(x[i])) << i;
}

std::string complaint(const std::string& text) {
  const auto rig = parse_rig(text, "rig.toml");
  EXPECT_FALSE(rig) << text;
  if (rig) return "";
  EXPECT_EQ(rig.error().exit_code(), 2);
  return rig.error().message;
}

TEST(Rig, ReadsBackWhatItWrote) {
  const Rig rig = full_rig();
  const auto again = parse_rig(rig_text(rig), "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  expect_same(rig, *again);
  EXPECT_EQ(again->name, rig.name);
  EXPECT_EQ(again->arm->from.date, rig.arm->from.date);
  EXPECT_EQ(again->arm->from.data_hash, rig.arm->from.data_hash);
  EXPECT_EQ(again->landmarks_from.method, "head-motion");
  EXPECT_EQ(again->surfaces[1].name, "wall");
  ASSERT_EQ(again->objects.size(), 2u);
  EXPECT_EQ(again->objects[0].mesh, "head one.stl");
  EXPECT_EQ(again->objects[1].name, "vise");
  EXPECT_TRUE(missing_parts(*again).empty());
}

TEST(Rig, EmptyRigReadsBackAndLacksEverything) {
  const auto again = parse_rig(rig_text(Rig{}), "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  expect_same(Rig{}, *again);
  EXPECT_FALSE(again->arm || again->camera || again->hand_eye || again->tip_pivot || again->delays);
  EXPECT_EQ(missing_parts(*again).size(), 11u);
}

TEST(Rig, WholeFilesOnly) {
  const ScratchFolder scratch;
  const auto path = scratch / "rig.toml";
  const Rig rig = full_rig();
  ASSERT_TRUE(write_rig(path, rig));
  Rig broken = rig;
  broken.arm->covariance = Eigen::MatrixXd::Identity(4, 4);
  EXPECT_FALSE(write_rig(path, broken));
  broken = rig;
  broken.hand_eye->X_marker_camera.rotation.coeffs() *= 2.0;
  EXPECT_FALSE(write_rig(path, broken));
  const auto kept = read_rig(path);
  ASSERT_TRUE(kept) << kept.error().message;
  expect_same(rig, *kept);
}

TEST(Rig, ComplaintsNameFileLineAndKey) {
  const std::string good = rig_text(full_rig());
  const auto with = [&](const std::string& key,
                        const std::string& value) {  // first line that sets `key`, set otherwise
    const auto at = good.find("\n" + key + " =") + 1;
    return good.substr(0, at) + key + " = " + value + "\n\n" + good.substr(good.find('\n', at) + 1);
  };
  EXPECT_NE(complaint("rig_version = 1\nnam = 'x'\n").find("rig.toml:2"), std::string::npos);
  EXPECT_NE(complaint("rig_version = 1\nnam = 'x'\n").find("nam"), std::string::npos);
  EXPECT_NE(complaint("name = 'x'\n").find("rig_version"), std::string::npos);
  EXPECT_NE(complaint("rig_version = 2\n").find("rig_version"), std::string::npos);
  EXPECT_NE(complaint("rig_version = \n").find("rig.toml:1"), std::string::npos);
  EXPECT_NE(complaint(with("gains", "[1, 1]")).find("gains"), std::string::npos);
  EXPECT_NE(complaint(with("gains", "[1, 1, 3]")).find("gains"), std::string::npos);
  EXPECT_NE(complaint(with("fx_px", "'wide'")).find("fx_px"), std::string::npos);
  EXPECT_NE(complaint(with("fx_px", "-560.0")).find("fx_px"), std::string::npos);
  EXPECT_NE(complaint(with("fx_px", "nan")).find("fx_px"), std::string::npos);
  EXPECT_NE(complaint(with("width_px", "640.5")).find("width_px"), std::string::npos);
  EXPECT_NE(complaint(with("rotation_qwxyz", "[1, 1, 0, 0]")).find("rotation_qwxyz"), std::string::npos);
  EXPECT_NE(complaint(with("date", "'yesterday'")).find("date"), std::string::npos);
}

TEST(Rig, ImpossibleCovariancesAreRefused) {
  const auto with = [](const std::string& matrix) {
    return "rig_version = 1\n[tip_pivot]\ntip_mm = [1, 2, 3]\nrms_mm = 0.1\ncovariance_mm2 = " + matrix +
           "\n";
  };
  EXPECT_TRUE(parse_rig(with("[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"), "rig.toml"));
  EXPECT_NE(complaint(with("[[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]")).find("symmetric"), std::string::npos);
  EXPECT_NE(complaint(with("[[-1, 0, 0], [0, 1, 0], [0, 0, 1]]")).find("negative"), std::string::npos);
  EXPECT_NE(complaint(with("[[1, 2, 0], [2, 1, 0], [0, 0, 1]]")).find("entry 2, 1"), std::string::npos);
  EXPECT_NE(complaint(with("[[1, 0], [0, 1]]")).find("covariance_mm2"), std::string::npos);
}

TEST(Rig, TwoSurfacesOfOneNameAreRefused) {
  Rig rig = full_rig();
  rig.surfaces[1].name = "table";
  EXPECT_NE(complaint(rig_text(rig)).find("used twice"), std::string::npos);
}

TEST(Rig, CornersGoRoundTheRectangle) {
  SurfaceCalibration s{"table", {so3_exp(Vector3(0, 0, 0.5)), Vector3(1, 2, 3)}, 0.75, 1.0, {}};
  EXPECT_NEAR((s.corner(0).m - Vector3(1, 2, 3)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((s.corner(1).m - s.corner(0).m).norm(), 0.75, 1e-15);
  EXPECT_NEAR((s.corner(2).m - s.corner(1).m).norm(), 1.0, 1e-15);
  EXPECT_NEAR((s.corner(3).m - s.corner(0).m).norm(), 1.0, 1e-15);
}

TEST(Rig, AChangedEncoderResetShows) {
  ArmCalibration arm;
  arm.rest_readings = Vector3(0.001, -0.002, 0.0);
  EXPECT_LT(rest_change(arm, Vector3(0.003, -0.001, 0.001)).cwiseAbs().maxCoeff(), kRestTolerance);
  EXPECT_GT(rest_change(arm, Vector3(0.001, 0.4, 0.0)).cwiseAbs().maxCoeff(), kRestTolerance);
}

TEST(Rig, RestReadingsThatNobodyHasReadAreLeftOut) {
  Rig rig = full_rig();
  rig.arm->rest_known = false;
  rig.arm->rest_readings = Vector3::Zero();
  const std::string text = rig_text(rig);
  EXPECT_EQ(text.find("rest_readings_deg"), std::string::npos);
  const auto again = parse_rig(text, "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_FALSE(again->arm->rest_known);
  EXPECT_EQ(again->arm->rest_readings.size(), 3);
  EXPECT_TRUE(parse_rig(rig_text(full_rig()), "rig.toml")->arm->rest_known);
}

Rig chain_rig() {
  Rig rig = full_rig();
  Random random(2, "rig/chain");
  auto& model = rig.arm->model;
  model = {.kind = device::ArmModel::Kind::dh, .name = "six \"axes\""};
  for (int j = 0; j < 6; ++j)
    model.joints.push_back({0.1 * random.normal(), random.normal(), 0.1 * random.normal(), random.normal()});
  model.joints[1].range = {-1.25, 0.75};
  model.tool = vector(random);
  model.tool_known = true;
  model.tool_turn = rotation(random);
  rig.nominal_arm = model;
  rig.nominal_arm.joints[0].a += 0.001;
  rig.arm->correction = {Eigen::VectorXd::Constant(6, 1.01), Eigen::VectorXd::LinSpaced(6, -0.1, 0.2)};
  rig.arm->rest_readings = Eigen::VectorXd::LinSpaced(6, 0.1, 0.6);
  rig.arm->covariance = covariance(random, 24);
  return rig;
}

std::vector<double> chain_numbers(const device::ArmModel& model) {
  std::vector<double> all;
  for (const auto& row : model.joints)
    for (const double number :
         {row.a, row.alpha, row.d, row.theta_offset, row.range.known() ? row.range.low : -99.0,
          row.range.known() ? row.range.high : 99.0})
      all.push_back(number);
  for (int i = 0; i < 3; ++i) all.push_back(model.tool[i]);
  for (int i = 0; i < 4; ++i) all.push_back(model.tool_turn.coeffs()[i]);
  return all;
}

TEST(Rig, AChainOfJointsIsReadAsItWasWritten) {
  const Rig rig = chain_rig();
  const std::string text = rig_text(rig);
  const auto again = parse_rig(text, "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  expect_same(rig, *again);
  for (const auto& [a, b] :
       {std::pair{rig.arm->model, again->arm->model}, {rig.nominal_arm, again->nominal_arm}}) {
    EXPECT_EQ(b.kind, device::ArmModel::Kind::dh);
    EXPECT_EQ(a.name, b.name);
    const auto x = chain_numbers(a), y = chain_numbers(b);
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], y[i], 1e-12 * (1.0 + std::abs(x[i])));
  }
  // The file of a PHANToM has no word of chains.
  EXPECT_EQ(rig_text(full_rig()).find("joint]]"), std::string::npos);
  EXPECT_EQ(rig_text(full_rig()).find("type"), std::string::npos);
}

TEST(Rig, ChainsThatCannotBeAreRefused) {
  const std::string good = rig_text(chain_rig());
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.rfind(from);
    EXPECT_NE(at, std::string::npos) << from;
    return complaint(text.replace(at, from.size(), to));
  };
  EXPECT_NE(changed("type = \"dh\"", "type = \"delta\"").find("type"), std::string::npos);
  EXPECT_NE(changed("type = \"dh\"", "").find("belongs to a chain"), std::string::npos);
  EXPECT_NE(changed("type = \"dh\"", "type = \"dh\"\nlengths_mm = [200, 200]").find("is a PHANToM's"),
            std::string::npos);
  EXPECT_NE(changed("[[arm.joint]]", "[[arm.joint]]\nb_mm = 1").find("b_mm"), std::string::npos);
  EXPECT_NE(changed("[[arm.joint]]\n", "[[arm.joint]]\nrange_deg = [10, -10]\n").find("range_deg"),
            std::string::npos);
  const std::string one_more = "\n[[arm.joint]]\na_mm = 1\nalpha_deg = 0\nd_mm = 1\n";
  EXPECT_NE(complaint(good + one_more).find("gains"), std::string::npos);
  EXPECT_NE(complaint(good + one_more + one_more + one_more).find("9 joints"), std::string::npos);
  Rig mixed = chain_rig();
  mixed.nominal_arm = {};
  EXPECT_NE(complaint(rig_text(mixed)).find("has 6 joints, nominal_arm has 3"), std::string::npos);
  mixed = chain_rig();
  mixed.arm->covariance = Eigen::MatrixXd::Identity(15, 15);
  EXPECT_NE(complaint(rig_text(mixed)).find("covariance_si"), std::string::npos);
}

TEST(Rig, TheCheckOfItsForcesReadsBackAndAnImpossibleOneIsRefused) {
  Rig rig = full_rig();
  EXPECT_EQ(rig_text(rig).find("[forces]"), std::string::npos);  // none unless it was checked
  ForceCalibration forces = force_calibration_of(rig, "maker \"7\"");
  forces.map << 0.98, 0.01, 0.0, 0.02, 1.03, -0.01, 0.0, 0.0, 0.99;
  forces.covariance = 1e-3 * Eigen::MatrixXd::Identity(9, 9);
  forces.joint_gains = Vector3(1.0, 0.97, 1.04);
  forces.joint_gains_std = Vector3(0.01, 0.02, 0.03);
  forces.gain = 1.01, forces.gain_std = 0.02, forces.peak = 8.5;
  forces.dead_man_button = 2;
  forces.date = "2026-01-31T12:00:00Z", forces.method = "ramps and weight",
  forces.data_hash = "0123456789abcdef";
  rig.forces = forces;
  const std::string text = rig_text(rig);
  const auto again = parse_rig(text, "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  const auto of_forces = [](const std::string& whole) {
    const auto from = whole.find("\n[forces]\n");
    return whole.substr(from, whole.find("\n[light]\n") - from);
  };
  EXPECT_EQ(of_forces(rig_text(*again)), of_forces(text));
  ASSERT_TRUE(again->forces);
  EXPECT_EQ(again->forces->identity, forces.identity);
  EXPECT_LT((again->forces->map - forces.map).norm(), 1e-12);
  EXPECT_EQ(again->forces->gain, forces.gain);
  EXPECT_EQ(again->forces->dead_man_button, 2);
  EXPECT_EQ(void_reason(*again, forces.identity), "");
  const auto without = [&](const std::string& key, const std::string& value) {
    const auto at = text.find("\n" + key + " =", text.find("[forces]")) + 1;
    const auto read = parse_rig(text.substr(0, at) + value + text.substr(text.find('\n', at)), "rig.toml");
    return read ? std::string() : read.error().message;
  };
  EXPECT_NE(without("gain", "# none").find("peak_n: is 8.5; without a gain"), std::string::npos)
      << without("gain", "# none");
  EXPECT_NE(without("joint_gains_std", "joint_gains_std = [0.01, -0.02, 0.03]").find("joint_gains_std"),
            std::string::npos);
  EXPECT_NE(without("joint_gains_std", "joint_gains_std = [0.01]").find("joint_gains_std"),
            std::string::npos);
  EXPECT_EQ(without("joint_gains_std", "# as files were before it was written"), "");
  EXPECT_NE(without("peak_n", "peak_n = -1").find("peak_n"), std::string::npos);
  EXPECT_NE(without("arm", "# none").find("arm"), std::string::npos);
  EXPECT_NE(without("dead_man_button", "dead_man_button = 40").find("dead_man_button"), std::string::npos);
  EXPECT_NE(without("date", "date = 'yesterday'").find("date"), std::string::npos);
}

TEST(Rig, OfOneCameraHasOneEyeAndNoLight) {
  Rig rig = full_rig();
  rig.right_camera.reset(), rig.right_hand_eye.reset(), rig.light.reset(), rig.objects.clear();
  const std::string text = rig_text(rig);  // as files were before there were two eyes
  for (const char* word : {"right_", "[light]", "[[object]]", "encoding"})
    EXPECT_EQ(text.find(word), std::string::npos) << word;
  const auto again = parse_rig(text, "rig.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_FALSE(has_two_eyes(*again));
  EXPECT_FALSE(again->light);
  EXPECT_EQ(again->camera->encoding, device::Encoding::root);
}

TEST(Rig, RightEyeIsWhereBothHandEyesPutIt) {
  const Rig rig = full_rig();
  ASSERT_TRUE(has_two_eyes(rig));
  Random random(5, "head");
  const Pose<World, CameraMarker> head{rotation(random), vector(random)};
  const auto right = right_eye_pose(rig, head * rig.hand_eye->X_marker_camera);
  const auto expected = head * rig.right_hand_eye->X_marker_camera;
  EXPECT_LT((right.translation - expected.translation).norm(), 1e-12);
  EXPECT_LT(right.rotation.angularDistance(expected.rotation), 1e-7);
}

TEST(Rig, ARationalLensKeepsAllItsCoefficientsAndTheirCovariance) {
  Rig rig = full_rig();
  Random random(3, "rational");
  rig.camera->model.kind = device::LensKind::rational;
  rig.camera->model.distortion = {0.45, 0.05, 0.0006, -0.0004, 0.002, 0.78, 0.17, 0.011};
  rig.camera->covariance = covariance(random, 12);
  rig.registration_covariance =
      covariance(random, 12 + 6 + 3 * static_cast<Eigen::Index>(rig.landmarks.size()));
  const auto again = parse_rig(rig_text(rig), "r.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->camera->model, rig.camera->model);
  EXPECT_LT((again->camera->covariance - rig.camera->covariance).norm(),
            1e-11 * rig.camera->covariance.norm());
  EXPECT_LT((again->registration_covariance - rig.registration_covariance).norm(),
            1e-11 * rig.registration_covariance.norm());
  EXPECT_EQ(again->right_camera->covariance.rows(), device::kLensParameters) << "beside one of five";
}

TEST(Rig, PartsCalibratedAnewNoLongerBelongTogether) {
  Rig rig = full_rig();
  // As one solve leaves it: the parts' covariances are blocks of the whole.
  Random random(2, "registration");
  constexpr Eigen::Index kLens = device::kLensParameters, kPlaces = kLens + 6;
  const Eigen::MatrixXd joint = of_five_coefficients(covariance(random, 9 + 6 + 3 * 5));
  rig.registration_covariance = joint;
  rig.camera->covariance = joint.topLeftCorner<kLens, kLens>();
  rig.hand_eye->covariance = joint.block<6, 6>(kLens, kLens);
  for (std::size_t i = 0; i < rig.landmarks.size(); ++i) {
    const auto at = kPlaces + 3 * static_cast<Eigen::Index>(i);
    rig.landmarks[i].covariance = joint.block<3, 3>(at, at);
  }
  const auto again = parse_rig(rig_text(rig), "r.toml");
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_LT((registration_covariance(*again) - joint).norm(), 1e-11 * joint.norm());

  const auto apart = [&](const Rig& changed) {
    const Eigen::MatrixXd C = registration_covariance(changed);
    EXPECT_EQ(C.rows(), joint.rows());
    EXPECT_TRUE(C.topRightCorner(kLens, C.cols() - kLens).isZero(0.0));
    EXPECT_TRUE((C.block<3, 3>(kPlaces, kPlaces + 3).isZero(0.0)));
    return C;
  };
  Rig other = rig;
  other.camera->covariance *= 1.1;
  EXPECT_EQ(apart(other)(0, 0), 1.1 * joint(0, 0));
  other = rig, other.hand_eye->covariance(5, 5) *= 1.1;
  EXPECT_EQ(apart(other)(kPlaces - 1, kPlaces - 1), 1.1 * joint(kPlaces - 1, kPlaces - 1));
  other = rig, other.landmarks[4].covariance *= 1.1;
  EXPECT_EQ(apart(other)(kPlaces + 12, kPlaces + 12), 1.1 * joint(kPlaces + 12, kPlaces + 12));
  // Of what is not calibrated nothing is known to be wrong.
  EXPECT_TRUE(registration_covariance(Rig{}).isZero(0.0));
  rig.landmarks.pop_back();
  const auto fewer = parse_rig(rig_text(rig), "r.toml");
  ASSERT_FALSE(fewer);
  EXPECT_NE(fewer.error().message.find("registration"), std::string::npos) << fewer.error().message;
}

TEST(Rig, ComplainsOfLightObjectsAndEncodingsByName) {
  const std::string head = "rig_version = 1\n";
  EXPECT_EQ(complaint(head + "[light]\nlamp_mm = [0, 500, 2000]\nambient = 0.0\n")
                .find("rig.toml:4: light.ambient"),
            0u);
  EXPECT_EQ(complaint(head + "[light]\nkey = 1.0\n").find("rig.toml:2: light.lamp_mm"), 0u);
  const std::string object = "[[object]]\nname = \"head\"\nmesh = \"head.stl\"\ntranslation_mm = [0, 0, 0]\n";
  EXPECT_NE(
      complaint(head + object + "mesh_unit = \"inch\"\nrotation_qwxyz = [1, 0, 0, 0]\n").find("mesh_unit"),
      std::string::npos);
  EXPECT_NE(
      complaint(head + object + "mesh_unit = \"mm\"\nrotation_qwxyz = [1, 0.5, 0, 0]\n").find("no rotation"),
      std::string::npos);
  const std::string good = object + "mesh_unit = \"mm\"\nrotation_qwxyz = [1, 0, 0, 0]\n";
  EXPECT_NE(complaint(head + good + good).find("used twice"), std::string::npos);
  std::string camera = rig_text(full_rig());
  camera.replace(camera.find("\"srgb\""), 6, "\"film\"");
  EXPECT_NE(complaint(camera).find("encoding"), std::string::npos);
}

TEST(RigFile, WhatIsNoRigIsNamed) {
  const auto refusal = [](std::string_view content) {
    const auto rig = parse_rig(content, "a.toml");
    return rig ? "none" : rig.error().message;
  };
  for (const auto& [content, words] :
       {std::pair("time_s,x_mm\n0,1\n", "a.toml: is a table of cells with commas; a rig file is expected: "),
        std::pair("0,1,2\n", "a.toml: is a table of cells with commas; a rig file is expected: "),
        std::pair("{\"rig\": 1}\n", "a.toml: is JSON; a rig file is expected: "),
        std::pair("x;y\n1;2\n", "a.toml: is separated by semicolons; a rig file is expected: ")}) {
    EXPECT_EQ(refusal(content).find(words), 0u) << refusal(content);
    EXPECT_NE(refusal(content).find("palpate rig new FILE"), std::string::npos) << refusal(content);
  }
  EXPECT_EQ(refusal("rig_version = 1\nname = a, b\n").find("a.toml:2: is not valid TOML"), 0u)
      << refusal("rig_version = 1\nname = a, b\n");
  EXPECT_EQ(read_rig("-").error().message, "-: standard input is not read; name a file");
}

}  // namespace
}  // namespace palpate::rig

#include <gtest/gtest.h>

#include "palpate/formats/formats_for_tests.h"
#include "palpate/formats/read.h"
#include "palpate/formats/write.h"

namespace palpate::formats {
namespace {

TEST(Formats, OnePoseInEveryFormThatTablesHave) {
  const std::pair<const char*, const char*> tables[] = {
      {"TUM", "# timestamp tx ty tz qx qy qz qw\n12.5 0.1 -0.2 0.3 0.5 -0.5 0.5 0.5\n"},
      {"tabs", "12.5\t0.1\t-0.2\t0.3\t0.5\t-0.5\t0.5\t0.5\r\n"},
      {"decimal commas", "time_s;x_mm;y_mm;z_mm;qw;qx;qy;qz\n12,5;100;-200;300;0,5;0,5;-0,5;0,5\n"},
      {"blanks and names", "time_s x_m y_m z_m qw qx qy qz\n12.5 0.1 -0.2 0.3 0.5 0.5 -0.5 0.5\n"},
      {"rostopic echo",
       "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.position.x,field.pose."
       "position.y,"
       "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
       "field.pose.orientation.w\n13000000000,1,12500000000,world,0.1,-0.2,0.3,0.5,-0.5,0.5,0.5\n"},
      {"a stamp in two",
       "time, .header.stamp.secs, .header.stamp.nsecs, .pose.pose.position.x, .pose.pose.position.y, "
       ".pose.pose.position.z, .pose.covariance, .pose.pose.orientation.x, .pose.pose.orientation.y, "
       ".pose.pose.orientation.z, .pose.pose.orientation.w\n1, 12, 500000000, 0.1, -0.2, 0.3, \"(0.0, "
       "1.0)\", 0.5, -0.5, 0.5, "
       "0.5\n"},
      {"PlotJuggler",
       "__time,/pose/pose/position/x,/pose/pose/position/y,/pose/pose/position/z,/pose/pose/orientation/x,"
       "/pose/pose/orientation/y,/pose/pose/orientation/z,/pose/pose/orientation/w\n"
       "12.5,0.1,-0.2,0.3,0.5,-0.5,0.5,0.5\n"},
      {"EuRoC",
       "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
       "v_RS_R_x [m s^-1]\n"
       "12500000000,0.1,-0.2,0.3,0.5,0.5,-0.5,0.5,9\n"},
      {"NDI",
       "Time,Tool,Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error\n12.5,x,7,OK,0.5,0.5,-0.5,0.5,100,-200,300,0.1\n"},
      {"combined API",
       "Test "
       "Date:\nSample:,Hour,Minutes,Seconds,ms,Xa,Ya,Za,qoa,qxa,qya,qza\n1,0,0,12,500,100,-200,300,0.5,0.5,-"
       "0.5,0.5,\n"},
  };
  for (const auto& [name, content] : tables) {
    SCOPED_TRACE(name);
    const auto poses = read_as<Poses>(content);
    ASSERT_EQ(poses.poses.size(), 1u);
    EXPECT_TRUE(poses.has_time);
    EXPECT_EQ(poses.left_out, 0u);
    expect_pose(poses.poses.front(), 12.5);
  }
}

TEST(Formats, AnglesOfNdiAreTurnsAboutZThenYThenX) {
  const auto poses = read_as<Poses>("Frame,State,Rz,Ry,Rx,Tx,Ty,Tz\n1,OK,90,0,0,1,2,3\n2,OK,0,90,90,1,2,3\n");
  ASSERT_EQ(poses.poses.size(), 2u);
  EXPECT_LT((poses.poses[0].rotation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-12);
  // x by 90 degrees first: y goes to z, which y's turn takes to x.
  EXPECT_LT((poses.poses[1].rotation * Vector3::UnitY() - Vector3::UnitX()).norm(), 1e-12);
}

TEST(Formats, RowsInWhichTheBodyWasHiddenAreLeftOutAndCounted) {
  const std::string header = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,State\n", seen = "0,1,2,3,1,0,0,0,OK\n";
  EXPECT_EQ(
      read_as<Poses>(header + seen + "1,,,,,,,,MISSING\n2,nan,nan,nan,nan,nan,nan,nan,x\n3,0,0,0,0,0,0,0,x\n")
          .left_out,
      3u);
  EXPECT_TRUE(holds(refusal(header + seen + "1,1,2,3,0,0,0,0,OK\n"), "the quaternion has length 0"));
  EXPECT_TRUE(
      holds(refusal(header + seen + "1,1,2,nan,1,0,0,0,OK\n"), "file:3: a part of the pose is missing"));
  EXPECT_TRUE(
      holds(refusal(header + seen + "1,1,2,north,1,0,0,0,OK\n"), "file:3: 'north' is no finite number"));
  const std::string tool = "Frame,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n";
  const auto poses = read_as<Poses>(
      tool +
      "1,OK,1,0,0,0,1,2,3\n2,Tool Missing,1,0,0,0,1,2,3\n"
      "3,OK,-3.697314E28,-3.697314E28,-3.697314E28,-3.697314E28,-3.697314E28,-3.697314E28,-3.697314E28\n");
  EXPECT_EQ(poses.poses.size(), 1u);
  EXPECT_EQ(poses.left_out, 2u);
  EXPECT_FALSE(poses.has_time) << "a frame's number is no time";
  EXPECT_TRUE(holds(refusal(tool + "1,MISSING,,,,,,,\n"), "seen in none of 1 row"));
  EXPECT_EQ(read_as<Poses>("0 1 2 3 0 0 0 1\n1 nan nan nan nan nan nan nan\n").left_out, 1u);
}

TEST(Formats, OfSeveralToolsSideBySideOneHasToBeNamed) {
  const std::string two =
      "Wav "
      "Time\tleft\tFrame\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz\tright\tFrame\tState\tQ0\tQx\tQy\tQz\tTx\tTy\tTz"
      "\n"
      "1.5\tleft\t1\tOK\t1\t0\t0\t0\t1\t2\t3\tright\t1\tOK\t1\t0\t0\t0\t4\t5\t6\n";
  EXPECT_TRUE(
      holds(refusal(two),
            "2 tools side by side (left, right); one of them is needed: palpate convert --tool NAME"));
  ReadOptions options;
  options.tool = "right";
  EXPECT_LT((read_as<Poses>(two, options).poses.at(0).translation - Vector3(0.004, 0.005, 0.006)).norm(),
            1e-12);
  EXPECT_TRUE(holds(refusal("x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,2,3,1,0,0,0\n", options),
                    "is a table of poses of one body without a name; remove --tool right"));
  options.tool = "middle";
  EXPECT_TRUE(holds(refusal(two, options), "without a tool 'middle'; it has left, right"));
}

TEST(Formats, AUnitThatNobodySaysIsAskedFor) {
  const std::string matrix = "1 0 0 10 0 1 0 20 0 0 1 30 0 0 0 1\n";
  ReadOptions mm;
  mm.metres_per_unit = 1e-3;
  for (const std::string& content : {matrix, std::string("x,y,z,qw,qx,qy,qz\n10,20,30,1,0,0,0\n")}) {
    EXPECT_TRUE(holds(refusal(content), "palpate convert --unit mm, or m"));
    EXPECT_LT((read_as<Poses>(content, mm).poses.at(0).translation - Vector3(0.01, 0.02, 0.03)).norm(),
              1e-12);
  }
  EXPECT_LT(
      (read_as<Poses>("1 0 0 10 0 1 0 20 0 0 1 30\n").poses.at(0).translation - Vector3(10, 20, 30)).norm(),
      1e-12)
      << "KITTI: m";
  const std::string blocks = "1 0 0 10\n0 1 0 20\n0 0 1 30\n0 0 0 1\n";
  EXPECT_LT((read_as<Transform>(blocks).matrix.topRightCorner<3, 1>() - Vector3(0.01, 0.02, 0.03)).norm(),
            1e-12);
  EXPECT_EQ(read_as<Poses>(blocks + "\n" + blocks).poses.size(), 2u);
}

TEST(Formats, PointsOfSlicerAreLps) {
  const std::string fcsv =
      "# Markups fiducial file version = 4.11\n# CoordinateSystem = SYSTEM\n# columns = "
      "id,x,y,z,ow,ox,oy,oz,vis,sel,"
      "lock,label,desc,associatedNodeID\n1,10,20,30,0,0,0,1,1,1,0,\"F, 1\",,\n";
  const auto with = [&](const std::string& system) {
    std::string text = fcsv;
    return text.replace(text.find("SYSTEM"), 6, system);
  };
  for (const char* system : {"LPS", "1", "LPS,,,,"}) {
    const auto points = read_as<Points>(with(system));
    EXPECT_LT((points.places.at(0) - Vector3(0.01, 0.02, 0.03)).norm(), 1e-12) << system;
    EXPECT_EQ(points.labels.at(0), "F, 1");
  }
  for (const char* system : {"RAS", "0"})
    EXPECT_LT((read_as<Points>(with(system)).places.at(0) - Vector3(-0.01, -0.02, 0.03)).norm(), 1e-12)
        << system;
  EXPECT_TRUE(holds(refusal(with("IJK")), "the coordinate system is 'IJK'"));
  const std::string json = R"({"markups": [{"type": "Fiducial", "coordinateSystem": "RAS", "controlPoints": [
      {"label": "A", "position": [10, 20, 30]}, {"label": "never placed", "position": [0, 0, 0], "positionStatus": "undefined"}]}]})";
  const auto points = read_as<Points>(json);
  ASSERT_EQ(points.places.size(), 1u);
  EXPECT_LT((points.places[0] - Vector3(-0.01, -0.02, 0.03)).norm(), 1e-12);
  EXPECT_TRUE(holds(refusal(R"({"markups": [{"controlPoints": [{"label": "A", "position": [1, 2]}]}]})"),
                    "'A' is no list of three"));
  EXPECT_TRUE(holds(refusal("{\"markups\": " + std::string(5000, '[') + std::string(5000, ']') + "}"),
                    "nested too deep"));
}

TEST(Formats, ASemicolonInALabelSeparatesNothing) {
  const auto points = read_as<Points>("x_mm,y_mm,z_mm,label\n1,2,3,a;b\n4,5,6,c\n");
  ASSERT_EQ(points.places.size(), 2u);
  EXPECT_EQ(points.labels, (std::vector<std::string>{"a;b", "c"}));
}

TEST(Formats, TransformsOfItkAreAsItStoresThem) {
  const auto tfm = [](const std::string& kind, const std::string& parameters,
                      const std::string& fixed = "0 0 0") {
    return "#Insight Transform File V1.0\n#Transform 0\nTransform: " + kind +
           "_double_3_3\nParameters: " + parameters + "\nFixedParameters: " + fixed + "\n";
  };
  Eigen::Matrix4d expected = Eigen::Matrix4d::Identity();
  expected.topLeftCorner<3, 3>() = Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()).toRotationMatrix();
  // A turn about a centre: y = A (x - c) + t + c.
  expected.topRightCorner<3, 1>() = 1e-3 * Vector3(1 + 10 + 20, 2 + 20 - 10, 3);
  const std::string h = "0.7071067811865476";
  for (const auto& [kind, parameters] :
       {std::pair<std::string, std::string>{"AffineTransform", "0 -1 0 1 0 0 0 0 1 1 2 3"},
        {"Euler3DTransform", "0 0 1.5707963267948966 1 2 3"},
        {"VersorRigid3DTransform", "0 0 " + h + " 1 2 3"},
        {"Similarity3DTransform", "0 0 " + h + " 1 2 3 1"},
        {"QuaternionRigidTransform", "0 0 " + h + " " + h + " 1 2 3"}})
    EXPECT_LT((read_as<Transform>(tfm(kind, parameters, "10 20 30")).matrix - expected).norm(), 1e-9) << kind;
  const Matrix3 zxy =
      read_as<Transform>(tfm("Euler3DTransform", "0.1 0.2 0.3 0 0 0")).matrix.topLeftCorner<3, 3>();
  const Matrix3 X = Eigen::AngleAxisd(0.1, Vector3::UnitX()).toRotationMatrix(),
                Y = Eigen::AngleAxisd(0.2, Vector3::UnitY()).toRotationMatrix(),
                Z = Eigen::AngleAxisd(0.3, Vector3::UnitZ()).toRotationMatrix();
  EXPECT_LT((zxy - Z * X * Y).norm(), 1e-12);
  const Matrix3 zyx = read_as<Transform>(tfm("Euler3DTransform", "0.1 0.2 0.3 0 0 0", "0 0 0 1"))
                          .matrix.topLeftCorner<3, 3>();
  EXPECT_LT((zyx - Z * Y * X).norm(), 1e-12);
  EXPECT_TRUE(holds(refusal(tfm("BSplineTransform", "1 2 3")), "bends space"));
  EXPECT_TRUE(holds(refusal(tfm("AffineTransform", "1 2 3")), "with 3 parameters"));
  EXPECT_TRUE(
      holds(refusal(tfm("AffineTransform", "0 -1 0 1 0 0 0 0 1 1 2 nan")), "'nan' is no finite number"));
  EXPECT_TRUE(holds(refusal(tfm("IdentityTransform", "") + "Transform: IdentityTransform_double_3_3\n"),
                    "holds 2 transforms"));
}

TEST(Formats, ALensOfFiveOrEightCoefficientsIsReadAndOneOfMoreIsNamed) {
  const Lens lens = read_as<Lens>(lens_with("0.1, -2.e-001, 0.001, 0.002, 0.05"));
  EXPECT_EQ(lens.fx, 500.0);
  EXPECT_EQ(lens.fy, 510.0);
  EXPECT_EQ(lens.cx, 320.0);
  EXPECT_EQ(lens.cy, 240.0);
  EXPECT_EQ(lens.distortion, (device::LensCoefficients{0.1, -0.2, 0.001, 0.002, 0.05}));
  EXPECT_EQ(lens.size, (std::array{640, 480}));
  EXPECT_EQ(read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002")).distortion[4], 0.0);
  EXPECT_EQ(read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002, 0, 0, 0, 0")).distortion[1], -0.2);
  EXPECT_EQ(read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002, 0, 0, 0, 0")).kind, device::LensKind::brown);
  const Lens rational =
      read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002, 0.05, 1, 0.5, 0.25, 0, 0, 0, 0, 0, 0"));
  EXPECT_EQ(rational.kind, device::LensKind::rational);
  EXPECT_EQ(rational.distortion, (device::LensCoefficients{0.1, -0.2, 0.001, 0.002, 0.05, 1.0, 0.5, 0.25}));
  EXPECT_TRUE(holds(refusal(lens_with("0.1, -0.2, 0.001, 0.002, 0, 1, 0, 0, 0.01, 0, 0, 0")),
                    "9 distortion coefficients, of a thin prism"));
  const std::string wide =
      "camera_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\ndistortion_model: equidistant\n"
      "distortion_coefficients: {data: [1, 2, 3, 4";
  EXPECT_EQ(read_as<Lens>(wide + "]}\n").kind, device::LensKind::fisheye);
  EXPECT_EQ(read_as<Lens>(wide + ", 0]}\n").distortion, (device::LensCoefficients{1.0, 2.0, 3.0, 4.0}));
  EXPECT_TRUE(
      holds(refusal(wide + ", 5]}\n"), "5 distortion coefficients of a fisheye lens; 4 are expected"));
  EXPECT_EQ(read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002") + "fisheye_model: 1\n").kind,
            device::LensKind::fisheye);
  EXPECT_EQ(read_as<Lens>(lens_with("0.1, -0.2, 0.001, 0.002") + "fisheye_model: 0\n").kind,
            device::LensKind::brown);
  EXPECT_TRUE(holds(refusal("camera_matrix: {data: [1, 0, 0, 0, 1, 0, 0, 0]}\n"), "no camera matrix of 3x3"));
  EXPECT_TRUE(holds(refusal("a: [1\nb: 2\n"), "no sound YAML"));
  EXPECT_TRUE(holds(refusal("<html><body>Not found</body></html>"), "XML or a web page"));
}

TEST(Formats, TheCameraInTheEffectorOfEasyHandeye) {
  const auto transform = read_as<Transform>(
      "parameters:\n  eye_on_hand: true\ntransformation:\n  qw: 0.5\n  qx: 0.5\n  qy: -0.5\n  qz: 0.5\n  x: "
      "0.1\n  y: -0.2\n  z: 0.3\n");
  EXPECT_LT((transform.matrix.topRightCorner<3, 1>() - kPlace).norm(), 1e-12);
  EXPECT_LT((transform.matrix.topLeftCorner<3, 3>() - kTurn.toRotationMatrix()).norm(), 1e-12);
  EXPECT_TRUE(holds(refusal("transformation:\n  qw: 2\n  qx: 0\n  qy: 0\n  qz: 0\n  x: 0\n  y: 0\n  z: 0\n"),
                    "length 2"));
}

// As numpy.lib.format describes it.
std::string npy(const std::string& shape, bool columns_first, const std::vector<double>& values) {
  std::string header = "{'descr': '<f8', 'fortran_order': " + std::string(columns_first ? "True" : "False") +
                       ", 'shape': (" + shape + "), }";
  header.resize((10 + header.size() + 64) / 64 * 64 - 11, ' ');
  header += '\n';
  std::string text("\x93NUMPY\x01\x00", 8);
  text += static_cast<char>(header.size() & 255);
  text += static_cast<char>(header.size() >> 8);
  text += header;
  return text.append(reinterpret_cast<const char*>(values.data()), 8 * values.size());
}

TEST(Formats, AnArrayOfNumpyInEitherOrder) {
  const Lens rows = read_as<Lens>(npy("3, 3", false, {500, 0, 320, 0, 510, 240, 0, 0, 1}));
  const Lens columns = read_as<Lens>(npy("3, 3", true, {500, 0, 0, 0, 510, 0, 320, 240, 1}));
  for (const Lens& lens : {rows, columns}) {
    EXPECT_EQ(lens.fx, 500.0);
    EXPECT_EQ(lens.cy, 240.0);
  }
  ReadOptions mm;
  mm.metres_per_unit = 1e-3;
  const auto points = read_as<Points>(npy("2, 3", true, {1, 4, 2, 5, 3, 6}), mm);
  EXPECT_LT((points.places.at(1) - Vector3(0.004, 0.005, 0.006)).norm(), 1e-12);
  EXPECT_TRUE(holds(refusal(npy("2, 3", false, {1, 2, 3, 4, 5, 6})), "says no unit"));
  EXPECT_TRUE(holds(refusal(npy("3, 3", false, {1, 2, 3})), "cut off"));
  EXPECT_TRUE(holds(refusal(npy("99999999999, 9999999999", false, {1})), "too large"));
}

TEST(Formats, WhatIsWrittenIsReadBackTheSame) {
  Poses poses;
  poses.has_time = true;
  poses.poses.push_back({1403636580.063555, kTurn, kPlace});
  const std::array size{640, 480};
  const Lens lens{500.5, 510.25, 320.125, 240.0, {0.1, -0.2, 1e-3, 2e-3, 0.05}, device::LensKind::brown,
                  size};
  const Lens wide{305.0, 304.5, 320.125, 240.0, {0.02, -0.01, 4e-3, -9e-4}, device::LensKind::fisheye, size};
  const Lens rational{420.0,
                      419.5,
                      320.125,
                      240.0,
                      {0.45, 0.05, 6e-4, -4e-4, 2e-3, 0.78, 0.17, 0.011},
                      device::LensKind::rational,
                      size};
  Transform transform;
  transform.matrix.topLeftCorner<3, 3>() = kTurn.toRotationMatrix();
  transform.matrix.topRightCorner<3, 1>() = kPlace;
  const Points points{{kPlace, -kPlace}, {"a", "b; c, d"}};
  int written = 0;
  for (const auto& form : written_forms())
    for (const Content& content :
         {Content{"", "", poses}, Content{"", "", points}, Content{"", "", lens}, Content{"", "", wide},
          Content{"", "", rational}, Content{"", "", transform}}) {
      SCOPED_TRACE(form.name);
      const auto text = text_of(content, form);
      if (!text) {
        EXPECT_TRUE(holds(text.error().message, "cannot be written as " + form.name)) << text.error().message;
        continue;
      }
      ++written;
      const auto again = parse(*text, "again");
      ASSERT_TRUE(again.has_value()) << again.error().message << "\n" << *text;
      ASSERT_EQ(again->value.index(), content.value.index());
      if (const auto* read = std::get_if<Poses>(&again->value)) {
        ASSERT_EQ(read->poses.size(), 1u);
        if (form.name != "kitti") {
          EXPECT_NEAR(read->poses[0].time_s, poses.poses[0].time_s, 3e-7);
        }
        EXPECT_LT((read->poses[0].translation - kPlace).norm(), 1e-15);
        EXPECT_LT(read->poses[0].rotation.angularDistance(kTurn), 1e-15);
      } else if (const auto* places = std::get_if<Points>(&again->value)) {
        EXPECT_EQ(places->labels, points.labels);
        EXPECT_LT((places->places.at(1) + kPlace).norm(), 1e-15);
      } else if (const auto* lens_again = std::get_if<Lens>(&again->value)) {
        const Lens& sent = std::get<Lens>(content.value);
        EXPECT_EQ(lens_again->fx, sent.fx);
        EXPECT_EQ(lens_again->cy, sent.cy);
        EXPECT_EQ(lens_again->kind, sent.kind);
        EXPECT_EQ(lens_again->distortion, sent.distortion);
        EXPECT_EQ(lens_again->size, sent.size);
      } else {
        EXPECT_LT((std::get<Transform>(again->value).matrix - transform.matrix).norm(), 1e-15);
      }
    }
  EXPECT_EQ(written, 18) << "csv holds two kinds, and there are three kinds of lens";
}

TEST(Formats, TheEndingSaysTheFormUnlessSomebodyDoes) {
  EXPECT_EQ(written_form("a.mrk.json", "")->name, "mrk-json");
  EXPECT_EQ(written_form("a.json", "")->name, "json");
  EXPECT_EQ(written_form("a.txt", "tum")->name, "tum");
  EXPECT_TRUE(holds(written_form("a.dat", "").error().message, "its ending says no form"));
}

TEST(Formats, WhatIsNotReadIsNamed) {
  for (const auto& [content, words] : {std::pair<std::string, const char*>{"NRRD0004\ntype: short\n", "NRRD"},
                                       {"MATLAB 5.0 MAT-file, Platform", "MATLAB"},
                                       {"{\"a\": 1}", "is JSON"},
                                       {"", "is empty"},
                                       {"1 2 3 4 5\n1 2 3 4 5\n", "rows of 5 numbers"},
                                       {"hello\nworld\n", "no form that is known"}})
    EXPECT_TRUE(holds(refusal(content), words)) << content << ": " << refusal(content);
}

// Frame 1 has lost its tool; behind the head stand bytes of a picture.
TEST(Formats, ASequenceInNrrdIsReadAsOneInMetaImage) {
  const std::string
      matrix = "1 0 0 10 0 1 0 -20 0 0 1 30 0 0 0 1",
      nrrd =
          "NRRD0004\n# a comment\ntype: unsigned char\ndimension: 3\nkinds: domain domain list\n"
          "Seq_Frame0000_Timestamp:=1.5\nSeq_Frame0000_ProbeToTrackerTransform:=" +
          matrix +
          "\nSeq_Frame0000_ProbeToTrackerTransformStatus:=OK\nSeq_Frame0001_Timestamp:=2.5\n"
          "Seq_Frame0001_ProbeToTrackerTransform:=" +
          matrix +
          "\nSeq_Frame0001_ProbeToTrackerTransformStatus:=INVALID\n\nSeq_Frame0002_ProbeToTrackerTransform:="
          "no";
  const auto poses = read_as<Poses>(nrrd);
  ASSERT_EQ(poses.poses.size(), 1u);
  EXPECT_EQ(poses.left_out, 1u);
  EXPECT_EQ(poses.poses[0].time_s, 1.5);
  EXPECT_LT((poses.poses[0].translation - Vector3(0.01, -0.02, 0.03)).norm(), 1e-15);
  EXPECT_TRUE(
      holds(refusal("NRRD0004\ntype: short\ndimension: 3\n\npixels"), "without a sequence of transforms"));
  auto broken = nrrd;
  broken.replace(broken.find("10 0 1"), 2, "x");
  EXPECT_TRUE(holds(refusal(broken), "file:7: ProbeToTrackerTransform is no matrix")) << refusal(broken);
}

TEST(Formats, AResultOfEasyHandeye2) {
  const std::string text =
      "parameters:\n  name: arm\n  calibration_type: eye_in_hand\n  robot_base_frame: base_link\ntransform:\n"
      "  translation:\n    x: 0.1\n    y: -0.2\n    z: 0.3\n  rotation:\n    x: 0.5\n    y: -0.5\n    z: "
      "0.5\n    w: 0.5\n";
  const auto transform = read_as<Transform>(text);
  EXPECT_LT((transform.matrix.topRightCorner<3, 1>() - kPlace).norm(), 1e-15);
  EXPECT_LT((Matrix3(transform.matrix.topLeftCorner<3, 3>()) - kTurn.toRotationMatrix()).norm(), 1e-12);
  EXPECT_EQ(parse(text, "file")->told, "the camera in the effector, m");
  std::string lame = text;
  lame.replace(lame.find("w: 0.5"), 6, "w: 0.9");
  EXPECT_TRUE(holds(refusal(lame), "length"));
}

TEST(Formats, ACameraOfKalibrsChain) {
  const std::string one =
      "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.76e-05]\n"
      "  distortion_model: radtan\n  intrinsics: [458.6, 457.3, 367.2, 248.4]\n  resolution: [752, 480]\n"
      "  rostopic: /cam0/image_raw\n";
  const auto lens = read_as<Lens>(one);
  EXPECT_EQ(lens.fx, 458.6);
  EXPECT_EQ(lens.cy, 248.4);
  EXPECT_EQ(lens.distortion, (device::LensCoefficients{-0.28, 0.07, 0.0002, 1.76e-05}));
  EXPECT_EQ(lens.size, (std::array{752, 480}));
  std::string two = one + one;
  two.replace(two.rfind("cam0:"), 5, "cam1:");
  two.replace(two.rfind("458.6"), 5, "500.5");
  EXPECT_TRUE(holds(refusal(two), "cam0, cam1"));
  EXPECT_EQ(read_as<Lens>(two, {.tool = "cam1"}).fx, 500.5);
  std::string fisheye = one;
  fisheye.replace(fisheye.find("radtan"), 6, "equidistant");
  const auto wide = read_as<Lens>(fisheye);
  EXPECT_EQ(wide.kind, device::LensKind::fisheye);
  EXPECT_EQ(wide.distortion, lens.distortion);
  std::string omni = one;
  omni.replace(omni.find("radtan"), 6, "fov");
  EXPECT_TRUE(holds(refusal(omni), "the lens 'fov' of Kalibr"));
}

}  // namespace
}  // namespace palpate::formats

// What files of other programs taught: each of these was once read wrongly, or refused in words that helped nobody.
#include <gtest/gtest.h>

#include "palpate/formats/formats_for_tests.h"
#include "palpate/formats/read.h"

namespace palpate::formats {
namespace {

TEST(FilesOfOthers, ATimeSaysItsUnitBehindItsName) {
  for (const auto& [name, cell] : {std::pair{"timestamp(s)", "12.5"},
                                   {"time [s]", "12.5"},
                                   {"Time (Seconds)", "12.5"},
                                   {"sec", "12.5"},
                                   {"ts", "12.5"},
                                   {"time_sec", "12.5"},
                                   {"t [ms]", "12500"},
                                   {"timestamp_us", "12500000"},
                                   {"Timestamp(ns)", "12500000000"}}) {
    SCOPED_TRACE(name);
    const auto poses = read_as<Poses>(
        fmt::format("{};x_m;y_m;z_m;qw;qx;qy;qz\n{};0.1;-0.2;0.3;0.5;0.5;-0.5;0.5\n", name, cell));
    ASSERT_TRUE(poses.has_time);
    expect_pose(poses.poses.at(0), 12.5);
  }
  const auto tum = read_as<Poses>("# when tx ty tz qx qy qz qw\n12.5 0.1 -0.2 0.3 0.5 -0.5 0.5 0.5\n");
  ASSERT_TRUE(tum.has_time) << "in a trajectory of TUM the first column is the time";
  expect_pose(tum.poses.at(0), 12.5);
  EXPECT_FALSE(read_as<Poses>("frame,x_m,y_m,z_m,qw,qx,qy,qz\n7,0.1,-0.2,0.3,0.5,0.5,-0.5,0.5\n").has_time);
}

TEST(FilesOfOthers, AQuaternionWithoutANameIsNoPlace) {
  ReadOptions m;
  m.metres_per_unit = 1.0;
  const auto plain = read_as<Poses>("sec,pos_x,pos_y,pos_z,x,y,z,w\n12.5,0.1,-0.2,0.3,0.5,-0.5,0.5,0.5\n", m);
  expect_pose(plain.poses.at(0), 12.5);
  const auto bag = read_as<Poses>(
      "stamp,secs,nsecs,pose,position,x,y,z,orientation,x,y,z,w,twist,x,y,z\n,12,500000000,,,0.1,-0.2,0.3,,0."
      "5,-0.5,0.5,0.5,,0,0,0\n");
  expect_pose(bag.poses.at(0), 12.5);
  EXPECT_TRUE(
      holds(refusal("a,x,y,z,b,x,y,z\n0,1,2,3,0,1,2,3\n", m), "file:1: names x, y and z more than once"));
  EXPECT_TRUE(
      holds(refusal("x,y,z,w,place\n0,0,0,1,2\n", m), "a quaternion, beside which the place is not known"));
}

TEST(FilesOfOthers, PlacesThatAreTurnedAreNoPoints) {
  ReadOptions mm;
  mm.metres_per_unit = 1e-3;
  for (const char* turn : {"q0,q1,q2,q3", "qx,qy,qz", "Roll,Pitch,Yaw", "yaw_deg",
                           "Rx (rad),Ry (rad),Rz (rad)", "rot_x,rot_y,rot_z", "orientation_x"}) {
    for (const char* place : {"x_mm,y_mm,z_mm", "x,y,z"})
      EXPECT_TRUE(holds(refusal(fmt::format("time_s,{},{}\n0,1,2,3,0,0,0,0\n", place, turn), mm),
                        fmt::format("file:1: has places, and {} which ", turn)));
  }
  for (const char* other : {"quality", "angles", "rxl_id", "roller", "arx", "note"})
    EXPECT_EQ(read_as<Points>(fmt::format("x_mm,y_mm,z_mm,{}\n1,2,3,4\n", other)).places.size(), 1u) << other;
  EXPECT_EQ(parse("time_s,x_mm,y_mm,z_mm\n0,1,2,3\n", "file", {})->told, "mm; their times are left out");
  EXPECT_EQ(parse("x_mm,y_mm,z_mm\n1,2,3\n", "file", {})->told, "mm");
}

TEST(FilesOfOthers, AMatrixByColumnsIsRefused) {
  ReadOptions mm;
  mm.metres_per_unit = 1e-3;
  EXPECT_EQ(read_as<Poses>("1 0 0 10 0 1 0 20 0 0 1 30 0 0 0 1\n", mm).poses.size(), 1u);
  EXPECT_TRUE(
      holds(refusal("1 0 0 0 0 1 0 0 0 0 1 0 10 20 30 1\n", mm), "file:1: the last row is 10 20 30 1"));
}

// As Motive 1.23 exports a take, shortened: two bodies, a marker of the first, a frame in which the second was hidden.
const std::string kTake =
    "Format Version,1.23,Take Name,a take,Rotation Type,Quaternion,Length Units,Centimeters,Coordinate "
    "Space,Global\n\n"
    ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body "
    "Marker,Rigid Body,Rigid "
    "Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
    ",Name,hand,hand,hand,hand,hand,hand,hand,hand:1,head,head,head,head,head,head,head\n"
    ",ID,\"A\",\"A\",\"A\",\"A\",\"A\",\"A\",\"A\",\"B\",\"C\",\"C\",\"C\",\"C\",\"C\",\"C\",\"C\"\n"
    ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Position,Rotation,Rotation,Rotation,"
    "Rotation,Position,"
    "Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,X,X,Y,Z,W,X,Y,Z\n"
    "0,12.5,0,0,0,1,1,2,3,9,0.5,-0.5,0.5,0.5,10,-20,30\n"
    "1,12.6,0,0,0,1,1,2,3,9,,,,,,,\n";

TEST(FilesOfOthers, ATakeOfMotiveHoldsRigidBodies) {
  ReadOptions head;
  head.tool = "head";
  const auto poses = read_as<Poses>(kTake, head);
  ASSERT_EQ(poses.poses.size(), 1u);
  EXPECT_EQ(poses.left_out, 1u);
  EXPECT_EQ(poses.poses[0].time_s, 12.5);
  EXPECT_LT((poses.poses[0].translation - Vector3(0.1, -0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT(poses.poses[0].rotation.angularDistance(kTurn), 1e-12);
  EXPECT_TRUE(holds(refusal(kTake), "rigid bodies hand, head; name one with --tool"));
  const auto changed = [](std::string_view from, std::string_view to) {
    std::string take = kTake;
    return take.replace(take.find(from), from.size(), to);
  };
  EXPECT_TRUE(holds(refusal(changed("Quaternion", "XYZ"), head),
                    "export rigid bodies with the rotation type Quaternion"));
  EXPECT_TRUE(holds(refusal(changed("Centimeters", "Inches"), head), "Length Units are 'Inches'"));
  EXPECT_TRUE(holds(refusal(changed("Frame,Time", "Frames,Time"), head), "without its line of axes"));
  EXPECT_TRUE(holds(refusal(changed(",30\n1,", ",\n1,"), head), "file:8: a part of the pose"));
}

TEST(FilesOfOthers, OfTwoCamerasInAFileOneHasToBeNamed) {
  std::string two;
  for (const char which : {'1', '2'})
    two += fmt::format(
        "M{0}: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {0}00., 0., 320., 0., {0}01., "
        "240., 0., 0., 1. ]\n"
        "D{0}: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0.{0}, 0., 0., 0., 0. ]\n",
        which);
  const std::string file = "%YAML:1.0\n---\n" + two;
  EXPECT_TRUE(holds(refusal(file), "two cameras, M1 and M2; name one with --tool"));
  ReadOptions right;
  right.tool = "M2";
  EXPECT_EQ(read_as<Lens>(file, right).fx, 200.0);
  EXPECT_EQ(read_as<Lens>(file, right).distortion[0], 0.2);
  right.tool = "M3";
  EXPECT_TRUE(holds(refusal(file, right), "name one with --tool"));
  EXPECT_TRUE(
      holds(refusal(lens_with("0.1, -0.2, 0.001, 0.002"), right), "holds one camera; remove --tool M3"));
  EXPECT_TRUE(holds(refusal("12.5 0.1 -0.2 0.3 0.5 -0.5 0.5 0.5\n", right), "remove --tool M3"));
}

TEST(FilesOfOthers, CoefficientsUnderAnyNameAreReadAndUnreadableOnesRefused) {
  const std::string matrix = "camera_matrix: {data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n";
  EXPECT_EQ(read_as<Lens>(matrix + "dist_coeff: [0.1, -0.2, 0, 0, 0.3]\n").distortion[4], 0.3);
  EXPECT_TRUE(holds(refusal(matrix + "dist_coeffs: [0.1, .Nan, 0, 0, 0]\n"),
                    "a distortion coefficient is no number"));
  EXPECT_TRUE(
      holds(refusal(matrix + "distortion: {type: radtan, parameters: {a: 1}}\n"), "is no number of a lens"));
  EXPECT_EQ(read_as<Lens>(matrix + "D: [0.1, 0, 0, 0]\ndistortion_model: kannala_brandt\n").kind,
            device::LensKind::fisheye);
  for (const char* model : {"distortion_model: fov", "distortion_model: radtan\ncamera_model: omni"})
    EXPECT_TRUE(holds(refusal(matrix + "D: [0.1, 0, 0, 0]\n" + model + "\n"), "plumb_bob"));
  const auto bare = parse(matrix, "file");
  ASSERT_TRUE(bare.has_value());
  EXPECT_EQ(bare->told, "px, without distortion");
}

TEST(FilesOfOthers, FiducialsOfSlicer3AreTurnedToo) {
  const auto points = read_as<Points>(
      "# Fiducial List file a.fcsv\n# name = a\n# columns = label,x,y,z,sel,vis\nmid,12.5,-93.5,7.5,1,1\n");
  EXPECT_LT((points.places.at(0) - Vector3(-0.0125, 0.0935, 0.0075)).norm(), 1e-12);
  EXPECT_EQ(points.labels.at(0), "mid");
}

TEST(FilesOfOthers, WhatIsNoTextIsNamed) {
  using namespace std::string_literals;
  for (const auto& [content, words] :
       {std::pair{"\xff\xfe"s + "x\0,\0"s, "UTF-16"}, std::pair{"PK\x03\x04rest"s, "ZIP archive"},
        std::pair{"\x1f\x8b\x08"s, "gunzip"},
        std::pair{"MATLAB 5.0 MAT-file Platform: posix\0\0"s, "writematrix"},
        std::pair{"[image]\n\nwidth\n640\n\n[narrow]\n\ncamera matrix\n1 0 0\n"s, "ost.yaml"},
        std::pair{"1 0.1 0.2 0.3 0 0 0 1\n\0\0\0\0"s, "zero bytes (from byte 22)"}})
    EXPECT_TRUE(holds(refusal(content), words)) << words;
  EXPECT_EQ(read_as<Poses>("1 0.1 0.2 0.3 0 0 0 1\r2 0.1 0.2 0.3 0 0 0 1\r").poses.size(), 2u)
      << "of an old Macintosh";
}

TEST(FilesOfOthers, AMatrixThatMovesByLessThanAMillimetreIsDoubted) {
  const auto told = [](const char* shift, double unit = 0.0) {
    ReadOptions options;
    options.metres_per_unit = unit;
    const auto read = parse(fmt::format("1 0 0 {}\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", shift), "file", options);
    return read ? read->told : read.error().message;
  };
  EXPECT_TRUE(holds(told("0.065"), "moves by 0.065 mm only; --unit m"));
  EXPECT_EQ(told("65"), "mm");
  EXPECT_EQ(told("0"), "mm");
  EXPECT_EQ(told("0.065", 1.0), "m");
}

}  // namespace
}  // namespace palpate::formats

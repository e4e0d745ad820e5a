#include "palpate/device/pose_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "palpate/core/file.h"
#include "palpate/core/random.h"
#include "tests/scratch_folder.h"

namespace palpate::device {
namespace {

namespace fs = std::filesystem;

class PoseFileTest : public testing::Test {
 protected:
  fs::path put(const std::string& name, const std::string& content) {
    EXPECT_TRUE(write_file(folder / name, content).has_value());
    return folder / name;
  }
  std::string complaint(const std::string& content, const PoseFileOptions& options = {}) {
    const auto file = read_poses(put("bad.csv", content), options);
    if (file) return "none";
    EXPECT_EQ(file.error().kind, Error::Kind::wrong_use);
    return file.error().message;
  }
  ScratchFolder scratch;
  const fs::path folder = scratch.path();
};

const Quaternion kTurn = so3_exp(Vector3(0.3, -0.7, 1.1));
const Vector3 kPlace(0.1, -0.2, 1.5);

std::string matrix_text(const char* separator) {
  const Matrix3 R = kTurn.toRotationMatrix();
  std::string text;
  for (int r = 0; r < 3; ++r)
    text += fmt::format("{:.17g}{sep}{:.17g}{sep}{:.17g}{sep}{:.17g}{sep}", R(r, 0), R(r, 1), R(r, 2),
                        1e3 * kPlace[r], fmt::arg("sep", separator));
  return text + fmt::format("0{sep}0{sep}0{sep}1", fmt::arg("sep", separator));
}

void expect_the_pose(const Expected<PoseFile>& file) {
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->poses.size(), 1u);
  EXPECT_NEAR((file->poses[0].translation - kPlace).norm(), 0.0, 1e-12);
  EXPECT_NEAR(angle_between(file->poses[0].rotation, kTurn), 0.0, 1e-9);
}

TEST_F(PoseFileTest, EveryFormGivesTheSamePose) {
  const auto q = [](const char* format) {
    return fmt::format(fmt::runtime(format), fmt::arg("w", kTurn.w()), fmt::arg("x", kTurn.x()),
                       fmt::arg("y", kTurn.y()), fmt::arg("z", kTurn.z()));
  };
  expect_the_pose(read_poses(
      put("a.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,100,-200,1500" + q(",{w},{x},{y},{z}\n"))));
  expect_the_pose(read_poses(
      put("b.csv", "qx,qy,qz,qw,x_m,y_m,z_m,other\n" + q("{x},{y},{z},{w}") + ",0.1,-0.2,1.5,7\n")));
  expect_the_pose(read_poses(put("c.csv", "12.5,0.1,-0.2,1.5" + q(",{x},{y},{z},{w}\n"))));
  expect_the_pose(read_poses(put("d.csv", matrix_text(",") + "\n")));
  expect_the_pose(
      read_poses(put("e.csv", "frame,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33\n0," +
                                  matrix_text(",") + "\n")));
  expect_the_pose(
      read_poses(put("f.csv",
                     "marker_x_mm,marker_y_mm,marker_z_mm,marker_qw,marker_qx,marker_qy,marker_qz\n"
                     "100,-200,1500" +
                         q(",{w},{x},{y},{z}\n"))));
  expect_the_pose(read_poses(
      put("g.igs.mha",
          "ObjectType = Image\nNDims = 3\nSeq_Frame0000_ToolToTrackerTransform = " + matrix_text(" ") +
              " \nSeq_Frame0000_ToolToTrackerTransformStatus = OK\n"
              "Seq_Frame0000_Timestamp = 3.5\nElementDataFile = LOCAL\n\x01\x02")));
  fs::create_directories(folder / "matrices");
  put("matrices/0001.txt", matrix_text(" ") + "\n");
  expect_the_pose(read_poses(folder / "matrices"));
}

TEST_F(PoseFileTest, HeaderlessRowsAreSortedByTimeAndRepeatedOnesKeptOnce) {
  const auto file = read_poses(put("a.csv", "2,0,0,0,0,0,0,1\n1,1,0,0,0,0,0,1\n2,0,0,0,0,0,0,1\n"));
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->poses.size(), 2u);
  EXPECT_EQ(file->poses[0].translation.x(), 1.0);
}

TEST_F(PoseFileTest, SegmentsAreLabelledZeroAndEmptyAreNone) {
  const auto file = read_poses(put("a.csv",
                                   "x_mm,y_mm,z_mm,qw,qx,qy,qz,hole\n0,0,0,1,0,0,0,7\n0,0,0,1,0,0,0,0\n"
                                   "0,0,0,1,0,0,0,\n0,0,0,1,0,0,0,left\n"),
                               {.segment_column = "hole"});
  ASSERT_TRUE(file.has_value()) << file.error().message;
  EXPECT_EQ(file->segments, (std::vector<std::string>{"7", "left"}));
  EXPECT_EQ(file->poses[1].segment, -1);
  EXPECT_EQ(file->poses[2].segment, -1);
  EXPECT_EQ(file->poses[3].segment, 1);
}

// StylusToReference = inverse(ReferenceToTracker) * StylusToTracker, composed here by typed poses.
TEST_F(PoseFileTest, SequencesComposeAndInvertTransformsAndSkipInvalidFrames) {
  Random random(3);
  const auto line = [](int frame, const char* name, const Pose<World, Tip>& X) {
    const Matrix3 R = X.matrix();
    std::string text = fmt::format("Seq_Frame{:04}_{}Transform =", frame, name);
    for (int r = 0; r < 3; ++r)
      text +=
          fmt::format(" {:.17g} {:.17g} {:.17g} {:.17g}", R(r, 0), R(r, 1), R(r, 2), 1e3 * X.translation[r]);
    return text + " 0 0 0 1\n";
  };
  const auto pose = [&] {
    const auto n = [&] { return Vector3(random.normal(), random.normal(), random.normal()); };
    return Pose<World, Tip>{so3_exp(n()), n()};
  };
  const auto stylus = pose(), reference = pose();
  const auto path =
      put("s.igs.mha", "ObjectType = Image\nNDims = 3\n" + line(0, "StylusToTracker", stylus) +
                           "Seq_Frame0000_StylusToTrackerTransformStatus = INVALID\n" +
                           line(0, "ReferenceToTracker", reference) + line(1, "StylusToTracker", stylus) +
                           line(1, "ReferenceToTracker", reference) + "ElementDataFile = LOCAL\n");
  const auto file = read_poses(path, {.transform = "StylusToReference"});
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->poses.size(), 1u);
  const auto expected = reference.inverse() * Pose<World, Bat>{stylus.rotation, stylus.translation};
  EXPECT_NEAR((file->poses[0].translation - expected.translation).norm(), 0.0, 1e-12);
  EXPECT_NEAR(angle_between(file->poses[0].rotation, expected.rotation), 0.0, 1e-12);

  const auto unnamed = read_poses(path);
  ASSERT_FALSE(unnamed.has_value());
  EXPECT_NE(unnamed.error().message.find("ReferenceToTracker, StylusToTracker"), std::string::npos);
  EXPECT_FALSE(read_poses(path, {.transform = "StylusToProbe"}).has_value());
}

TEST_F(PoseFileTest, BadFilesAreRefusedWithTheirPlace) {
  const std::string head = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";
  EXPECT_NE(complaint(head).find("no poses"), std::string::npos);
  EXPECT_NE(complaint("").find("is empty"), std::string::npos);
  EXPECT_NE(complaint(head + "0,1,2,3,1,0,0,0\n" + head + "1,1,2,3,1,0,0,0\n")
                .find("bad.csv:3: the header stands here once more; remove the line"),
            std::string::npos)
      << "no row in which the body was hidden";
  EXPECT_NE(complaint("x_mm,y_m,z_mm,qw,qx,qy,qz\n1,2,3,1,0,0,0\n").find("has x_mm and y_m; one unit"),
            std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm,Roll_deg,yaw\n1,2,3,0,0\n")
                .find("the turn is read from a quaternion alone, not from Roll_deg,yaw"),
            std::string::npos);
  EXPECT_NE(complaint("x_mm,y_mm,z_mm,qw,qx,qy\n1,2,3,1,0,0\n").find("but not qz, which is needed too"),
            std::string::npos);
  EXPECT_NE(complaint("a,b\n1,2\n").find("'x_mm' is missing"), std::string::npos);
  EXPECT_NE(
      complaint(head + "0,1,2,3,1,0,0,0\n0,1,2,3,0,0,0,0\n").find("bad.csv:3: the quaternion has length 0"),
      std::string::npos);
  EXPECT_NE(complaint(head + "0,nan,2,3,1,0,0,0\n").find("x_mm is 'nan'"), std::string::npos);
  EXPECT_NE(complaint("1,0,0,0,0,2,0,0,0,0,1,0\n").find("is no rotation"), std::string::npos);
  EXPECT_NE(complaint("1,0,0,0,0,1,0,0,0,0,1,0,10,20,30,1\n")
                .find("the last row is 10 20 30 1, 0 0 0 1 is expected"),
            std::string::npos)
      << "stored column by column";
  EXPECT_NE(complaint("m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23,m30,m31,m32,m33\n"
                      "1,0,0,0,0,1,0,0,0,0,1,0,10,20,30,1\n")
                .find("bad.csv:2: the last row is 10 20 30 1"),
            std::string::npos);
  EXPECT_NE(complaint("1,2,3\n").find("no header and 3 columns"), std::string::npos);
  EXPECT_NE(complaint(head + "0,1,2,3,1,0,0,0\n", {.segment_column = "hole"}).find("'hole' is missing"),
            std::string::npos);
  EXPECT_NE(
      complaint("0,0,0,0,0,0,0,1\n", {.segment_column = "hole"}).find("bad.csv: column 'hole' is needed"),
      std::string::npos);
  EXPECT_NE(complaint(head + "0,1,2,1e300,1,0,0,0\n").find("bad.csv:2: is 1e+297 m away"), std::string::npos);
  EXPECT_NE(complaint(head + "1.7e18,1,2,3,1,0,0,0\n").find("time_s is 1.7e+18; at most 1e+11"),
            std::string::npos)
      << "a time in nanoseconds";
  EXPECT_NE(complaint("1,0,0,1e300,0,1,0,0,0,0,1,0\n").find("m away"), std::string::npos);
  EXPECT_NE(complaint("1e300,0,0,0,0,1,0,0,0,0,1,0\n").find("is no rotation"), std::string::npos);
  EXPECT_FALSE(read_poses(folder / "none.csv").has_value());
  EXPECT_FALSE(read_poses(folder).has_value()) << "the folder holds bad.csv";
}

// A log's frame, a tracker's state, a number that was missing: nobody reads them.
TEST_F(PoseFileTest, OtherColumnsMayHoldText) {
  const std::string head = "frame_id,time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,State,error\n";
  const auto file =
      read_poses(put("more.csv", head + "world,0,1,2,3,1,0,0,0,OK,nan\nworld,1,1,2,4,1,0,0,0,Missing,\n"));
  ASSERT_TRUE(file.has_value()) << file.error().message;
  ASSERT_EQ(file->poses.size(), 2u);
  EXPECT_DOUBLE_EQ(file->poses[1].translation.z(), 0.004);
  EXPECT_EQ(file->table.text[1][9], "Missing");
  for (const char* row : {"w,0,,2,3,1,0,0,0,OK,0", "w,0,1,2,3,1,0,0,-,OK,0", "w,later,1,2,3,1,0,0,0,OK,0"})
    EXPECT_NE(complaint(head + row + "\n").find(", a number is expected"), std::string::npos) << row;
  std::string matrix = "name_of_it,m00,m01,m02,m03,m10,m11,m12,m13,m20,m21,m22,m23\nx,1,0,0,0,0,1,0,0,0,0,1,";
  EXPECT_EQ(complaint(matrix + "5\n"), "none");
  EXPECT_NE(complaint(matrix + "y\n").find("m23 is 'y', a number is expected"), std::string::npos);
}

TEST_F(PoseFileTest, ColumnsAreKnownInAnyLetters) {
  const auto file = parse_poses("Time_s,X_mm,Y_MM,z_mm,QW,Qx,qy,qz\n2.5,1,2,3,1,0,0,0\n", "poses.csv");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(file->has_time);
  EXPECT_EQ(file->poses.at(0).time_s, 2.5);
  EXPECT_LT((file->poses[0].translation - Vector3(0.001, 0.002, 0.003)).norm(), 1e-15);
  const auto both = parse_poses("X_mm,x_mm,y_mm,z_mm,qw,qx,qy,qz\n9,1,2,3,1,0,0,0\n", "poses.csv");
  ASSERT_TRUE(both) << both.error().message;
  EXPECT_EQ(both->poses.at(0).translation.x(), 0.001) << "the one that has the very name";
}

TEST_F(PoseFileTest, ATimeOfAnotherNameIsToldAndNotRead) {
  const std::string pose = ",x_mm,y_mm,z_mm,qw,qx,qy,qz\n5,1,2,3,1,0,0,0\n";
  for (const char* name : {"timestamp", "Time", "t", "stamp", "time_ms"}) {
    const auto file = read_poses(put("time.csv", name + pose));
    ASSERT_TRUE(file) << file.error().message;
    EXPECT_FALSE(file->has_time);
    EXPECT_EQ(file->unread_time, name);
  }
  EXPECT_EQ(read_poses(put("time.csv", "frame" + pose))->unread_time, "");
  EXPECT_EQ(read_poses(put("time.csv", "time_s" + pose))->unread_time, "");
}

TEST_F(PoseFileTest, FilesOfOtherProgramsAreNamed) {
  const auto says = [&](const std::string& content, const std::string& words,
                        const PoseFileOptions& options = {}) {
    EXPECT_NE(complaint(content, options).find(words), std::string::npos) << complaint(content, options);
  };
  says("# t x y z qx qy qz qw\n0.1 1 2 3 0 0 0 1\n0.2 1 2 3 0 0 0 1\n",
       "bad.csv: is separated by blanks; commas are expected. Without header 8 cells a row are t,x,y,z,qx");
  says(matrix_text(" "), "is separated by blanks");
  says("0,1;1,5;2;3;0;0;0;1\n", "has decimal commas");
  says("NRRD0004\ntype: unsigned char\n", "is an NRRD file", {.transform = "AToB"});
  says("#Insight Transform File V1.0\nTransform: X\nParameters: 1 0 0\n", "is a transform of ITK");
  says("Frame,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error\n1,1,0,0,0,5,6,7,0.1\n", "is an export of NDI's programs");
  says("rig_version = 1\n", "is a rig file");
}

TEST_F(PoseFileTest, BrokenSequencesAreRefusedWithTheirPlace) {
  const std::string head = "ObjectType = Image\nNDims = 3\n",
                    pose = "Seq_Frame7_AToBTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
  EXPECT_NE(complaint(head + "Seq_Frame0012").find("holds no transforms"), std::string::npos)
      << "cut short inside a number";
  EXPECT_NE(complaint(head + "Seq_Frame7_Timestamp = inf\n" + pose).find("bad.csv:3: Timestamp is 'inf'"),
            std::string::npos);
  EXPECT_NE(complaint(head + "Seq_Frame7_Timestamp =  \n" + pose).find("bad.csv:3: Timestamp is ''"),
            std::string::npos);
  EXPECT_NE(complaint(head + "Seq_Frame7_AToBTransform = 1 2 3\n").find("16 finite numbers are expected"),
            std::string::npos);
  // Each of them would be a tool of its own, for which the file is read once more.
  std::string many = head;
  for (int i = 0; i < 300; ++i)
    many += fmt::format("Seq_Frame7_A{}ToBTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n", i);
  EXPECT_NE(complaint(many).find("bad.csv:259: a recording of at most 256 transforms"), std::string::npos)
      << complaint(many);
}

TEST_F(PoseFileTest, AFolderOfMatricesNamesTheFileThatIsNone) {
  fs::create_directory(folder / "poses");
  put("poses/1.txt", matrix_text(" "));
  const auto complaint_about = [&](const std::string& content) {
    put("poses/2.txt", content);
    const auto file = read_poses(folder / "poses");
    return file ? "none" : file.error().message;
  };
  EXPECT_EQ(complaint_about(matrix_text("; ")), "none");
  EXPECT_EQ(complaint_about(matrix_text(",")), "none");
  EXPECT_EQ(complaint_about("1,0,0,5;0,1,0,6;0,0,1,7;0,0,0,1"), "none");
  EXPECT_EQ(complaint_about(matrix_text("\t")), "none");
  EXPECT_EQ(complaint_about("time_s,x_mm\n0,1\n"),
            (folder / "poses").string() +
                ": holds a table, 2.txt; text files of one 4x4 matrix each are expected, name the table");
  EXPECT_EQ(
      complaint_about("#Insight Transform File V1.0\nTransform: X\n"),
      (folder / "poses/2.txt").string() +
          ": is a transform of ITK or 3D Slicer (.tfm, .txt), which is not read; the 16 numbers of a 4x4 "
          "matrix are expected");
  EXPECT_NE(complaint_about("1 0 0").find("2.txt: holds 3 numbers; the 16 of a 4x4 matrix are expected"),
            std::string::npos);
  EXPECT_NE(complaint_about("1 0 0 +\n0").find("2.txt: '+' is not a finite number"), std::string::npos);
  EXPECT_NE(complaint_about("1 \b0").find("2.txt: '?0' is not a finite number"), std::string::npos);
  EXPECT_NE(complaint_about(matrix_text(" ") + " inf").find("'inf' is not a finite number"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::device

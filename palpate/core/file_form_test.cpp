#include "palpate/core/file_form.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "palpate/core/csv.h"
#include "palpate/core/toml.h"

namespace palpate::inline core {
namespace {

struct Example {
  FileForm form;
  const char* content;
};

// As other programs write them, cut short.
const std::vector<Example> kForeign = {
    {FileForm::blanks, "# timestamp tx ty tz qx qy qz qw\n1700000000.0 0.01 0.0 1.0 0 0 0 1\n"},  // TUM
    {FileForm::blanks, "1.0e+00 0 0 0.1 0 1 0 0 0 0 1 0\n"},                                      // KITTI
    {FileForm::blanks, "x y z\n1   2  NaN\n"},
    {FileForm::tabs, "time_s\tx_mm\ty_mm\n0\t1\t2\n"},
    {FileForm::tabs, "1\t2\t3\n4\t5\t6\n"},
    {FileForm::semicolons, "time_s;x_mm;y_mm\n0;1.5;2\n"},
    {FileForm::semicolons, "\xEF\xBB\xBFtime_s;x_mm\n"},
    {FileForm::decimal_commas, "time_s;x_mm;y_mm\n0,5;1,5;2\n"},
    {FileForm::decimal_commas, "0,5;1,5;2,0\n"},
    {FileForm::decimal_commas, "time_s\tx_mm\n0,5\t1,5\n"},
    {FileForm::json, "[\n  {\"x\": 1, \"y\": 2}\n]\n"},
    {FileForm::json, "[[1, 0, 0, 0], [0, 1, 0, 0]]\n"},
    {FileForm::json,
     "{\"@schema\": \"https://raw.githubusercontent.com/markups-schema.json#\", \"markups\": []}"},
    {FileForm::xml, "<?xml version=\"1.0\"?>\n<a/>\n"},
    {FileForm::nrrd, "NRRD0004\n# Complete NRRD file format\ntype: unsigned char\ndimension: 4\n"},
    {FileForm::metaimage, "ObjectType = Image\nNDims = 3\n"},
    {FileForm::fiducials,
     "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n"
     "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
     "1,2.5,3,4,0,0,0,1,1,1,0,F-1,,\n"},
    {FileForm::itk_transform,
     "#Insight Transform File V1.0\n#Transform 0\n"
     "Transform: AffineTransform_double_3_3\nParameters: 1 0 0 0 1 0 0 0 1 5 6 7\n"},
    {FileForm::ndi,
     "Tools,Port 1: 8700340,Frame,Face,State,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error\n1,,17,1,OK,1,0,0,0,5,6,7,0.1\n"},
    {FileForm::ndi, "Frame,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Error\n1,1,0,0,0,5,6,7,0.1\n"},
    {FileForm::rig, "# A rig.\nrig_version = 1\nname = \"desk, left\"\n"},
    {FileForm::rig, "name = \"desk\"\nrig_version = 1\n"},
    {FileForm::toml, "[world]\nrate_hz = 100\n"},
    {FileForm::toml, "[[surface]]\nname = \"table\"\n"},
};

TEST(FileForm, IsToldByTheFirstLines) {
  for (const auto& example : kForeign)
    EXPECT_EQ(static_cast<int>(form_of(example.content)), static_cast<int>(example.form)) << example.content;
  EXPECT_EQ(form_of(std::string("PK\x03\x04\0", 5)), FileForm::binary);
  EXPECT_EQ(form_of(std::string("a;b\0", 4)), FileForm::binary);
  EXPECT_EQ(form_of("NRRD0005\nencoding: gzip\n\n\x1f\x01"),
            FileForm::nrrd);  // its data stand behind its head
}

TEST(FileForm, TablesWithCommasAreNothingElse) {
  for (const char* table :
       {"t_s,x_mm\n0,1\n", "0, 1, 2\n3, 4, 5\n", "0,\t1,\t2\n3,\t4,\t5\n", "label,x_mm\na;b,1\nc;d,2\n",
        "name,x\nleft [1],2\n", "x_mm,y_mm,z_mm,note\n1,2,3,a = b\n", "\"x_mm\",\"y_mm\"\n1,2\n",
        "Frame,Q0,Qx,Qy,Qz,Tx,Ty,Tz,x_mm\n1,1,0,0,0,5,6,7,0.1\n", "-1,-2\n",
        "x_mm,y_mm,z_mm,Port 1: 87\n1,2,3,4\n"})
    EXPECT_EQ(static_cast<int>(form_of(table)), static_cast<int>(FileForm::commas)) << table;
  for (const char* column :
       {"x_mm\n1\n2\n", "1\n2\n3\n", "the name of it\nleft hand\n", "", "\n\n# only words\n"})
    EXPECT_EQ(static_cast<int>(form_of(column)), static_cast<int>(FileForm::unknown)) << column;
}

// However long the file is.
TEST(FileForm, IsNotLookedForBehindTheFirstLines) {
  EXPECT_EQ(form_of("x_mm,y_mm\n" + std::string(5000, '#') + "\n0,1;\x01\n"), FileForm::commas);
}

TEST(FileForm, ATableReaderSaysWhatTheFileIsAndWhatToDo) {
  std::set<std::string> words;
  for (const auto& example : kForeign) {
    const auto table = parse_csv(example.content, "a.csv");
    ASSERT_FALSE(table.has_value()) << example.content;
    EXPECT_EQ(table.error().message.find("a.csv: "), 0u) << table.error().message;
    EXPECT_NE(table.error().message.find(std::string(words_of(example.form)) + "; "), std::string::npos)
        << table.error().message;
    EXPECT_EQ(table.error().exit_code(), 2);
    words.insert(std::string(words_of(example.form)));
  }
  EXPECT_EQ(words.size(), 13u) << "each form has words of its own";
}

TEST(FileForm, AReaderOfTomlSaysWhatTheFileIs) {
  for (const auto& example : kForeign) {
    if (is_toml(example.form)) continue;
    const auto file = parse_toml(example.content, "a.toml");
    ASSERT_FALSE(file.has_value()) << example.content;
    EXPECT_EQ(file.error().message,
              "a.toml: " + std::string(words_of(example.form)) + "; a TOML file is expected");
  }
  EXPECT_EQ(parse_toml("x_mm,y_mm\n1,2\n", "a.toml").error().message,
            "a.toml: is a table of cells with commas; a TOML file is expected");
  // what is meant as TOML keeps the line of its fault
  EXPECT_EQ(parse_toml("a = 1\nb = 2,5\n", "a.toml").error().message.find("a.toml:2: is not valid TOML"), 0u);
}

}  // namespace
}  // namespace palpate::inline core

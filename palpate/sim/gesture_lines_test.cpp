#include "palpate/sim/gesture_lines.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace palpate::sim {
namespace {

struct Doer : device::Person {
  Expected<void> ask(const device::Request& request) override {
    asked.push_back(request);
    if (request.gesture == device::Gesture::touch && request.index > 3)
      return refused(ErrorCode::no_more, "there are four");
    return {};
  }
  Expected<bool> ready() override { return there; }
  std::vector<device::Request> asked;
  bool there = false;
};

struct Lines : ::testing::Test {
  std::array<int, 2> in{};
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> out{std::tmpfile(), &std::fclose};
  Doer person;
  std::unique_ptr<GestureLines> lines;

  Lines() {
    EXPECT_EQ(pipe(in.data()), 0);
    lines = std::make_unique<GestureLines>(in[0], out.get());
  }
  ~Lines() override {
    close(in[0]);
    if (in[1] >= 0) close(in[1]);
  }
  void say(const std::string& text) const {
    EXPECT_EQ(write(in[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  std::string answers() const {
    std::rewind(out.get());
    std::string all;
    for (int c = 0; (c = std::fgetc(out.get())) != EOF;) all += static_cast<char>(c);
    return all;
  }
};

TEST_F(Lines, WhatIsSaidIsDoneAndToldOnceThePersonIsThere) {
  lines->look(person);  // nothing has come: it does not wait
  say("{\"gesture\": \"touch\", \"what\": \"ta");
  lines->look(person);
  EXPECT_TRUE(person.asked.empty());
  say("ble\", \"index\": 2}\n");
  lines->look(person);
  ASSERT_EQ(person.asked.size(), 1u);
  EXPECT_EQ(person.asked[0].what, "table");
  EXPECT_EQ(answers(), "");
  person.there = true;
  lines->look(person);
  lines->look(person);
  EXPECT_EQ(answers(), "{\"ready\":\"touch\"}\n");
}

TEST_F(Lines, WhatCannotBeDoneIsAnsweredAndTheNextLineCounts) {
  say("{\"gesture\": \"touch\", \"what\": \"table\", \"index\": 4}\nnonsense\n{\"gesture\": \"look\"}\n");
  person.there = true;
  lines->look(person);
  const std::string said = answers();
  EXPECT_NE(said.find("\"no_more\":true"), std::string::npos);
  EXPECT_NE(said.find("\"no_more\":false"), std::string::npos);
  EXPECT_NE(said.find("{\"ready\":\"look\"}"), std::string::npos);
  EXPECT_EQ(person.asked.size(), 2u);
}

TEST_F(Lines, AnEndlessLineIsForgottenAndTheEndIsNoFault) {
  for (int i = 0; i < 60; ++i) {
    say(std::string(1000, 'x'));
    lines->look(person);
  }
  say("\n");
  lines->look(person);
  EXPECT_NE(answers().find("refused"), std::string::npos);
  close(in[1]);
  in[1] = -1;
  lines->look(person);
  lines->look(person);
  EXPECT_TRUE(person.asked.empty());
}

}  // namespace
}  // namespace palpate::sim

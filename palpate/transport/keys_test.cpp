#include "palpate/transport/keys.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::transport {
namespace {

mode_t mode_of(const std::filesystem::path& path) {
  struct stat info {};
  EXPECT_EQ(stat(path.c_str(), &info), 0);
  return info.st_mode & 07777;
}

std::string new_key() { return make_key_pair()->public_key; }

TEST(Keys, APairIsKeptForItsUserAloneAndComesBack) {
  ScratchFolder scratch;
  const auto folder = scratch / "config" / "palpate";
  const auto pair = *make_key_pair();
  ASSERT_TRUE(write_key_pair(folder, pair, false));
  EXPECT_EQ(mode_of(folder), 0700u);
  EXPECT_EQ(mode_of(folder / "secret_key"), 0600u);
  const auto read = read_key_pair(folder);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->public_key, pair.public_key);
  EXPECT_EQ(read->secret_key, pair.secret_key);
  EXPECT_NE(pair.public_key, make_key_pair()->public_key);

  const auto again = write_key_pair(folder, *make_key_pair(), false);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("--force"), std::string::npos);
  EXPECT_EQ(read_key_pair(folder)->public_key, pair.public_key);
  EXPECT_TRUE(write_key_pair(folder, *make_key_pair(), true));
  EXPECT_NE(read_key_pair(folder)->public_key, pair.public_key);
}

TEST(Keys, SecretsThatOthersReadAndHalvesThatDoNotFitAreRefused) {
  ScratchFolder scratch;
  const auto none = read_key_pair(scratch.path());
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("palpate keys new"), std::string::npos);
  ASSERT_TRUE(write_key_pair(scratch.path(), *make_key_pair(), false));
  chmod((scratch / "secret_key").c_str(), 0644);
  const auto open = read_key_pair(scratch.path());
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("chmod 600"), std::string::npos);
  const auto a = *make_key_pair(), b = *make_key_pair();
  ASSERT_TRUE(write_key_pair(scratch.path(), {a.public_key, b.secret_key}, true));
  EXPECT_FALSE(read_key_pair(scratch.path()));
}

TEST(Keys, EditsKeepWhatAPersonWroteAndAKeyHasOneRole) {
  ScratchFolder scratch;
  const auto one = new_key(), two = new_key();
  ASSERT_TRUE(
      write_file(scratch / "authorized_keys", "# the lab's own list\n\ngraphics " + one + " big screen\n"));
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::observer, two, "tablet"}));
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::operator_, one, "big screen"}));
  EXPECT_EQ(*read_file(scratch / "authorized_keys"),
            "# the lab's own list\n\nobserver " + two + " tablet\noperator " + one + " big screen\n");
  const auto read = read_authorized_keys(scratch.path());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->role_of(one), Role::operator_);
  EXPECT_EQ(read->role_of(two), Role::observer);
  EXPECT_EQ(read->role_of(new_key()), std::nullopt);
  EXPECT_EQ(*revoke_keys(scratch.path(), "big screen"), 1u);
  EXPECT_EQ(read_authorized_keys(scratch.path())->role_of(one), std::nullopt);
  EXPECT_FALSE(revoke_keys(scratch.path(), "big screen"));
  EXPECT_EQ(*revoke_keys(scratch.path(), two), 1u);
  EXPECT_EQ(*read_file(scratch / "authorized_keys"), "# the lab's own list\n\n");
}

TEST(Keys, LinesThatAreNoneAdmitNobodyAndAreNamed) {
  const auto one = new_key();
  const auto read = parse_authorized_keys(
      "king " + one + "\ngraphics short\ngraphics\nobserver " + one + " first\noperator " + one + " second\n",
      "file");
  ASSERT_EQ(read.keys.size(), 1u);
  EXPECT_EQ(read.keys[0].role, Role::observer);
  ASSERT_EQ(read.complaints.size(), 4u);
  EXPECT_EQ(read.complaints[0], "file:1: 'king' is no role; observer, graphics or operator is expected");
  EXPECT_EQ(read.complaints[3].substr(0, 7), "file:5:");
}

TEST(Keys, AListThatOthersCanWriteToIsRefused) {
  ScratchFolder scratch;
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::graphics, new_key(), ""}));
  chmod((scratch / "authorized_keys").c_str(), 0666);
  const auto read = read_authorized_keys(scratch.path());
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("chmod 644"), std::string::npos);
}

// Each in a process of its own, as commands are; all of them at once.
void all_at_once(const std::vector<std::function<bool()>>& commands) {
  int gate[2];
  ASSERT_EQ(pipe(gate), 0);
  std::vector<pid_t> children;
  for (const auto& command : commands) {
    children.push_back(fork());
    ASSERT_GE(children.back(), 0);
    if (children.back() != 0) continue;
    char opened = 0;
    close(gate[1]);
    static_cast<void>(read(gate[0], &opened, 1));  // until the last process has been started
    _exit(command() ? 0 : 1);
  }
  close(gate[0]);
  close(gate[1]);
  for (const pid_t child : children) {
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
}

// A server decides by the code whether to keep the list it has.
TEST(Keys, AListThatCannotBeReadForWantOfDescriptorsSaysSoByItsCode) {
  ScratchFolder scratch;
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::graphics, new_key(), ""}));
  // Sanitizers want descriptors the first time that they meet a kind of thread.
  std::thread(std::function<void()>([] {})).join();
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{3, before.rlim_max};  // those of a terminal; a thread with a table of its own has no more
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  const auto wanting = read_authorized_keys(scratch.path());
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  ASSERT_FALSE(wanting);
  EXPECT_EQ(wanting.error().code, ErrorCode::exhausted);
  EXPECT_NE(wanting.error().message.find("ulimit -n"), std::string::npos) << wanting.error().message;
  EXPECT_TRUE(read_authorized_keys(scratch.path()));
  chmod((scratch / "authorized_keys").c_str(), 0666);
  EXPECT_NE(read_authorized_keys(scratch.path()).error().code, ErrorCode::exhausted)
      << "what is wrong with the file itself";
}

TEST(Keys, CommandsAtOnceLoseNoKeyAndBringNoneBack) {
  constexpr int kRounds = 8, kAtOnce = 6;
  for (int round = 0; round < kRounds; ++round) {
    SCOPED_TRACE(round);
    ScratchFolder scratch;
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::operator_, new_key(), "leaving"}));
    std::vector<std::string> keys;
    std::vector<std::function<bool()>> commands;
    commands.push_back([&] { return revoke_keys(scratch.path(), "leaving").has_value(); });
    for (int i = 0; i < kAtOnce; ++i) {
      keys.push_back(new_key());
      const std::string key = keys.back(), address = "tcp://host:" + std::to_string(1000 + i);
      commands.push_back([&, key] {
        return authorize_key(scratch.path(), {Role::observer, key, ""}).has_value();
      });
      commands.push_back(
          [&, key, address] { return trust_server(scratch.path(), address, key).has_value(); });
    }
    all_at_once(commands);
    const auto admitted = *read_authorized_keys(scratch.path());
    const auto servers = *read_known_servers(scratch.path());
    EXPECT_EQ(admitted.keys.size(), keys.size());  // and not who was revoked
    EXPECT_EQ(servers.size(), keys.size());
    for (const auto& key : keys) EXPECT_EQ(admitted.role_of(key), Role::observer);
  }
}

TEST(Keys, ALockThatCannotBeHadIsSaidInWordsAndNotWaitedForForEver) {
  ScratchFolder scratch;
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::observer, new_key(), "there"}));
  const std::string before = *read_file(scratch / "authorized_keys");
  const int held = open((scratch / "lock").c_str(), O_RDWR);
  ASSERT_GE(held, 0);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  const auto refused = revoke_keys(scratch.path(), "there");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("nothing was changed"), std::string::npos);
  EXPECT_EQ(*read_file(scratch / "authorized_keys"), before);
  close(held);
  EXPECT_TRUE(revoke_keys(scratch.path(), "there"));
}

// Who can write to the folder can put back a list with a key that was taken out.
TEST(Keys, InAFolderThatOthersCanWriteToNothingIsBelieved) {
  ScratchFolder scratch;
  ASSERT_TRUE(write_key_pair(scratch.path(), *make_key_pair(), false));
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::operator_, new_key(), ""}));
  ASSERT_TRUE(trust_server(scratch.path(), "tcp://host:1", new_key()));
  ASSERT_TRUE(server_identity(scratch.path()));
  for (const mode_t open : {0777, 0720, 0702}) {
    chmod(scratch.path().c_str(), open);
    const auto server = server_identity(scratch.path());
    ASSERT_FALSE(server) << open;
    EXPECT_NE(server.error().message.find("chmod 700"), std::string::npos);
    EXPECT_FALSE(client_identity(scratch.path(), "tcp://host:1", ""));
    EXPECT_FALSE(read_authorized_keys(scratch.path()));
  }
  chmod(scratch.path().c_str(), 0755);  // to be read by others is no harm
  EXPECT_TRUE(server_identity(scratch.path()));
  chmod(scratch.path().c_str(), 0700);
}

TEST(Keys, AClientNeedsItsOwnPairAndTheServersKey) {
  ScratchFolder scratch;
  const std::string address = "tcp://127.0.0.1:5555";
  EXPECT_FALSE(client_identity(scratch.path(), address, ""));
  ASSERT_TRUE(write_key_pair(scratch.path(), *make_key_pair(), false));
  const auto unknown = client_identity(scratch.path(), address, "");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("palpate keys trust " + address), std::string::npos);
  const auto key = new_key(), other = new_key();
  EXPECT_EQ(client_identity(scratch.path(), address, key)->server_key, key);
  ASSERT_TRUE(trust_server(scratch.path(), address, other));
  ASSERT_TRUE(trust_server(scratch.path(), address, key));
  EXPECT_EQ(client_identity(scratch.path(), address, "")->server_key, key);
  EXPECT_EQ(trust_server(scratch.path(), address, "nonsense").error().exit_code(), 2);
}

TEST(Roles, EachMayDoWhatTheOneBeforeMay) {
  for (const auto control :
       {scene::Control::begin, scene::Control::reset, scene::Control::pause, scene::Control::resume}) {
    EXPECT_FALSE(may(Role::observer, control));
    EXPECT_EQ(may(Role::graphics, control), control == scene::Control::begin);
    EXPECT_TRUE(may(Role::operator_, control));
  }
  for (const auto role : {Role::observer, Role::graphics, Role::operator_})
    EXPECT_EQ(role_named(role_name(role)), role);
}

}  // namespace
}  // namespace palpate::transport

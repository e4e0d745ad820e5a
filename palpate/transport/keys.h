// Who may talk to a physics server over TCP: key pairs, admitted public keys with their roles, and the
// servers this machine trusts.
//
// Keys are CURVE keys (Curve25519 as in CurveZMQ, ZeroMQ RFC 26), written in Z85 (RFC 32): 40 characters.
// They live in one folder of the user's as text that a person can read and edit:
//   secret_key        this machine's own pair; readable by its user alone
//   authorized_keys   ROLE PUBLIC-KEY [NAME], a line each: who is admitted to the server of this machine
//   known_servers     ADDRESS PUBLIC-KEY, a line each: which servers this machine believes
//   lock              taken (flock) while one of the others is changed
// Empty lines and lines that begin with # are comments; edits keep them. Files that others can write to are
// refused, in a folder that others can write to all of them, a secret that others can read as well. What
// changes a file waits some seconds for others that do; then it is refused. Functions without state; any
// thread.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"

namespace palpate::transport {

// What a client may do. Each role may do what the one before may.
enum class Role {
  observer,   // see: scene, states, clock
  graphics,   // and serve the ball for the person before its picture
  operator_,  // and reset, pause, resume
};
std::string_view role_name(Role role);
std::optional<Role> role_named(std::string_view name);
bool may(Role role, scene::Control control);

struct KeyPair {
  std::string public_key, secret_key;  // Z85
};

// $XDG_CONFIG_HOME/palpate, or ~/.config/palpate.
Expected<std::filesystem::path> keys_folder();
// Whether the text is a public key as CURVE takes it.
bool is_key(std::string_view text);

Expected<KeyPair> make_key_pair();
// Refused where there is none, with what to do about it.
Expected<KeyPair> read_key_pair(const std::filesystem::path& folder);
// Makes the folder where it is missing. Refused where a pair is there, unless it may be replaced.
Expected<void> write_key_pair(const std::filesystem::path& folder, const KeyPair& pair, bool replace);

struct AuthorizedKey {
  Role role = Role::observer;
  std::string key, name;
};
struct AuthorizedKeys {
  std::vector<AuthorizedKey> keys;
  std::vector<std::string> complaints;  // about lines that are none; such a line admits nobody

  std::optional<Role> role_of(std::string_view key) const;
};
// Never fails: what cannot be understood admits nobody.
AuthorizedKeys parse_authorized_keys(std::string_view text, const std::string& source);
// Empty where there is no file. ErrorCode::exhausted: for want of descriptors or memory, which says nothing about the file.
Expected<AuthorizedKeys> read_authorized_keys(const std::filesystem::path& folder);
// A key that is there already gets the new role and name.
Expected<void> authorize_key(const std::filesystem::path& folder, const AuthorizedKey& key);
// By key or name; how many were taken out.
Expected<std::size_t> revoke_keys(const std::filesystem::path& folder, std::string_view key_or_name);

// Address ("tcp://host:port") to public key.
Expected<std::map<std::string, std::string>> read_known_servers(const std::filesystem::path& folder);
Expected<void> trust_server(const std::filesystem::path& folder, const std::string& address,
                            const std::string& key);

// What an encrypted server and an encrypted client need.
struct ServerIdentity {
  KeyPair own;
  std::filesystem::path folder;  // authorized_keys is read there, again whenever it changes
};
struct ClientIdentity {
  KeyPair own;
  std::string server_key;
};
Expected<ServerIdentity> server_identity(const std::filesystem::path& folder);
// `server_key` empty: the one known for `address`.
Expected<ClientIdentity> client_identity(const std::filesystem::path& folder, const std::string& address,
                                         const std::string& server_key);

}  // namespace palpate::transport

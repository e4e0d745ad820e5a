#include <fmt/format.h>

#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/transport/keys.h"
#include "palpate/transport/local_endpoint.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

struct KeysArguments {
  std::string folder, key, role = "graphics", name, address, json;
  bool force = false;

  Expected<std::filesystem::path> place() const {
    return folder.empty() ? transport::keys_folder() : Expected<std::filesystem::path>(folder);
  }
};

Expected<void> make_keys(const KeysArguments& options) {
  const auto folder = options.place();
  if (!folder) return tl::unexpected(folder.error());
  const auto pair = transport::make_key_pair();
  if (!pair) return tl::unexpected(pair.error());
  if (auto written = transport::write_key_pair(*folder, *pair, options.force); !written) return written;
  fmt::print(
      "public key  {}\n"
      "kept in     {}\n"
      "As a client: on the physics server's machine, palpate keys authorize '{}' --role graphics\n"
      "As a server: on each client's machine, palpate keys trust tcp://HOST:PORT '{}'\n",
      pair->public_key, (*folder / "secret_key").string(), pair->public_key, pair->public_key);
  return {};
}

Expected<void> show_keys(const KeysArguments& options) {
  const auto folder = options.place();
  if (!folder) return tl::unexpected(folder.error());
  const auto admitted = transport::read_authorized_keys(*folder);
  if (!admitted) return tl::unexpected(admitted.error());
  const auto servers = transport::read_known_servers(*folder);
  if (!servers) return tl::unexpected(servers.error());
  const auto own = transport::read_key_pair(*folder);
  if (!options.json.empty()) {
    Json json;
    json["public_key"] = own ? Json(own->public_key) : Json();
    json["authorized"] = Json::array();
    for (const auto& key : admitted->keys)
      json["authorized"].push_back(
          {{"role", transport::role_name(key.role)}, {"key", key.key}, {"name", key.name}});
    json["known_servers"] = Json::array();
    for (const auto& [address, key] : *servers)
      json["known_servers"].push_back({{"address", address}, {"key", key}});
    json["warnings"] = admitted->complaints;
    return write_json(options.json, json);
  }
  print_line("public key  " + (own ? own->public_key : "none: " + own.error().message));
  for (const auto& key : admitted->keys)
    fmt::print("admitted    {:<9} {} {}\n", transport::role_name(key.role), key.key, excerpt(key.name, 100));
  for (const auto& [address, key] : *servers) fmt::print("server      {} {}\n", excerpt(address, 100), key);
  for (const auto& complaint : admitted->complaints) notice("warning: " + complaint);
  return {};
}

Expected<void> admit(const KeysArguments& options) {
  const auto folder = options.place();
  if (!folder) return tl::unexpected(folder.error());
  const auto role = transport::role_named(options.role);
  if (!role)
    return wrong_use("--role '{}': observer, graphics or operator is expected", excerpt(options.role));
  if (auto done = transport::authorize_key(*folder, {*role, options.key, options.name}); !done) return done;
  fmt::print("admitted as {}; a running server knows within a second\n", options.role);
  return {};
}

Expected<void> take_back(const KeysArguments& options) {
  const auto folder = options.place();
  if (!folder) return tl::unexpected(folder.error());
  const auto removed = transport::revoke_keys(*folder, options.key);
  if (!removed) return tl::unexpected(removed.error());
  fmt::print("{} taken out; a running server knows within a second\n", counted(*removed, "key"));
  return {};
}

Expected<void> trust(const KeysArguments& options) {
  const auto folder = options.place();
  if (!folder) return tl::unexpected(folder.error());
  const auto address = transport::parse_endpoint(options.address, transport::EndpointUse::connect);
  if (!address) return tl::unexpected(address.error());
  if (!address->encrypted)
    return wrong_use("{}: only tcp:// addresses need keys", excerpt(options.address, 100));
  return transport::trust_server(*folder, address->address, options.key);
}

}  // namespace

void add_keys(CLI::App& program) {
  auto* keys =
      program.add_subcommand("keys", "Keys for encrypted connections: whom this machine admits and believes");
  keys->require_subcommand(1);
  auto options = std::make_shared<KeysArguments>();
  const auto command = [&](const char* name, const char* help,
                           Expected<void> (*action)(const KeysArguments&)) {
    auto* made = keys->add_subcommand(name, help);
    made->add_option("--keys", options->folder,
                     "Folder of the keys; default $XDG_CONFIG_HOME/palpate or ~/.config/palpate");
    on(made, [options, action] { return action(*options); });
    return made;
  };
  command("new", "Make this machine's pair of keys", make_keys)
      ->add_flag("--force", options->force, "Replace a pair that is there");
  command("show", "Print this machine's public key, who is admitted, and which servers are believed",
          show_keys)
      ->add_option("--json", options->json, "Write the same as JSON to FILE (- = standard output)")
      ->type_name("FILE");
  auto* authorize = command("authorize", "Admit a client to the physics server of this machine", admit);
  authorize->add_option("KEY", options->key, "The client's public key")->required();
  authorize
      ->add_option("--role", options->role,
                   "observer sees, graphics also serves, operator also resets and pauses")
      ->capture_default_str();
  authorize->add_option("--name", options->name, "Whose key it is");
  command("revoke", "Admit a client no longer", take_back)
      ->add_option("KEY", options->key, "Its public key, or its name")
      ->required();
  auto* believe = command("trust", "Enter the key of a physics server", trust);
  believe->add_option("ADDRESS", options->address, "tcp://HOST:PORT as given to palpate graphics --connect")
      ->required();
  believe->add_option("KEY", options->key, "The server's public key")->required();
}

}  // namespace palpate::tools::commands

#include "tools/commands/record_options.h"

#include "palpate/render/picture_file.h"
#include "tools/commands/checks.h"

namespace palpate::tools::commands {

void add_picture_option(CLI::App& command, RecordOptions& options) {
  command
      .add_option("--pictures", options.pictures,
                  "The camera's pictures in the recording: none, jpeg or lossless. They may show people")
      ->check(one_of({"none", "jpeg", "lossless"}))
      ->capture_default_str();
}

void add_record_options(CLI::App& command, RecordOptions& options) {
  command
      .add_option("--record", options.file,
                  "Record the session in this new file (MCAP; see palpate recording, palpate replay)")
      ->type_name("FILE");
  add_picture_option(command, options);
}

Expected<record::session::PictureRecording> picture_recording(const RecordOptions& options) {
  record::session::PictureRecording how;
  if (options.pictures == "none") return how;
  if (options.file.empty()) return wrong_use("--pictures {}: goes with --record FILE", options.pictures);
  how.lossless = options.pictures == "lossless";
  if (!how.lossless)
    how.jpeg = [](const device::CameraImage& image) {
      return render::jpeg_bytes(image.rgb, image.width, image.height);
    };
  return how;
}

}  // namespace palpate::tools::commands

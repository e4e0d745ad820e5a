#include "palpate/desktop/sound_out.h"

#include <AL/al.h>
#include <AL/alc.h>
#include <dlfcn.h>

#include <array>
#include <cstdlib>

#include "palpate/desktop/hit_sound.h"

namespace palpate::desktop {
namespace {

void say_nothing(const char*, int, const char*, int, const char*, ...) {}  // NOLINT(cert-dcl50-cpp): as ALSA

// OpenAL and ALSA print all that they look for and do not find; what a person should know is in our refusal.
void quieten_sound_libraries() {
  setenv("ALSOFT_LOGLEVEL", "0", 0);
  using Handler = void (*)(const char*, int, const char*, int, const char*, ...);
  // The one that OpenAL will open; it stays.
  if (void* alsa = dlopen("libasound.so.2", RTLD_NOW); alsa != nullptr)
    if (auto* set = reinterpret_cast<int (*)(Handler)>(dlsym(alsa, "snd_lib_error_set_handler")))
      set(&say_nothing);
}

}  // namespace

struct SoundOut::Impl {
  ALCdevice* device = nullptr;
  ALCcontext* context = nullptr;
  std::array<ALuint, 8> sources{}, buffers{};
  std::size_t next = 0;
  bool voices = false;
  std::string name;

  ~Impl() {
    if (voices) {
      for (const ALuint source : sources) {
        alSourceStop(source);
        alSourcei(source, AL_BUFFER, 0);
      }
      alDeleteSources(static_cast<ALsizei>(sources.size()), sources.data());
      alDeleteBuffers(static_cast<ALsizei>(buffers.size()), buffers.data());
    }
    if (context != nullptr) {
      alcMakeContextCurrent(nullptr);
      alcDestroyContext(context);
    }
    if (device != nullptr) alcCloseDevice(device);
  }
};

Expected<std::unique_ptr<SoundOut>> SoundOut::open() {
  quieten_sound_libraries();
  auto impl = std::make_unique<Impl>();
  impl->device = alcOpenDevice(nullptr);
  if (impl->device == nullptr)
    return refused("sound: no device to play on; connect speakers or start the desktop's sound server");
  impl->context = alcCreateContext(impl->device, nullptr);
  if (impl->context == nullptr || !alcMakeContextCurrent(impl->context))
    return refused("sound: the sound device cannot be used (error {:#x})",
                   static_cast<unsigned>(alcGetError(impl->device)));
  alGenSources(static_cast<ALsizei>(impl->sources.size()), impl->sources.data());
  alGenBuffers(static_cast<ALsizei>(impl->buffers.size()), impl->buffers.data());
  if (alGetError() != AL_NO_ERROR) return refused("sound: the sound device has no voices left");
  impl->voices = true;
  if (const char* name = alcGetString(impl->device, ALC_DEVICE_SPECIFIER)) impl->name = name;
  return std::unique_ptr<SoundOut>(new SoundOut(std::move(impl)));
}

SoundOut::SoundOut(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SoundOut::~SoundOut() = default;

void SoundOut::play(std::span<const std::int16_t> samples) {
  const ALuint source = impl_->sources[impl_->next], buffer = impl_->buffers[impl_->next];
  impl_->next = (impl_->next + 1) % impl_->sources.size();
  alSourceStop(source);
  alSourcei(source, AL_BUFFER, 0);
  alBufferData(buffer, AL_FORMAT_MONO16, samples.data(), static_cast<ALsizei>(samples.size_bytes()),
               kSoundRate);
  alSourcei(source, AL_BUFFER, static_cast<ALint>(buffer));
  alSourcePlay(source);
}

const std::string& SoundOut::device() const { return impl_->name; }

}  // namespace palpate::desktop

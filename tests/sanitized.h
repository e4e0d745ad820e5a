// Whether this build runs under a sanitizer, which has its own malloc, stacks and pages. GCC says so by macros, clang by
// features.
#pragma once

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PALPATE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PALPATE_SANITIZED 1
#endif
#endif

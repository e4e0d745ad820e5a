// Four floats at once, for the tree of boxes: what SSE2 and NEON do in one instruction, in the compiler's own
// vector types. Operators +, -, * and comparisons work lane by lane.
#pragma once

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace palpate::physics {

using Float4 = float __attribute__((vector_size(16)));
using Mask4 = int __attribute__((vector_size(16)));  // -1 where true, as comparisons of Float4 give it

inline Float4 four(float x) { return Float4{x, x, x, x}; }

#if defined(__SSE2__)
inline Float4 lower(Float4 a, Float4 b) { return _mm_min_ps(a, b); }
inline Float4 upper(Float4 a, Float4 b) { return _mm_max_ps(a, b); }
inline unsigned bits(Mask4 m) { return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(m))); }
#else
inline Float4 lower(Float4 a, Float4 b) { return a < b ? a : b; }
inline Float4 upper(Float4 a, Float4 b) { return a > b ? a : b; }
inline unsigned bits(Mask4 m) {
  return static_cast<unsigned>((m[0] & 1) | (m[1] & 2) | (m[2] & 4) | (m[3] & 8));
}
#endif

}  // namespace palpate::physics

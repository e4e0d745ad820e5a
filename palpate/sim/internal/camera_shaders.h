// The simulated camera's shaders: how table, wall, room, dots, board and arm look. GLSL 3.30, without
// #version.
#pragma once

#include <string>

namespace palpate::sim {

// Table and wall are drawn in parts that need more or less.
enum class SurfacePart { plain, shadowed, edge };
std::string table_shader(SurfacePart part);
std::string side_shader();  // of the table's slab
std::string wall_shader(SurfacePart part);
std::string leg_shader();    // of the table: a flat strip turned to the eye, shaded as a tube
std::string floor_shader();  // drawn once into a texture
std::string room_shader();   // floor and walls behind everything
std::string dot_shader();
std::string ball_shader();  // on a square that faces the eye
std::string board_shader();
std::string layer_shader();            // the arm's picture, bent through the lens
extern const char* const kTileVertex;  // parts of the picture instead of the whole
extern const char* const kArmVertex;
extern const char* const kArmFragment;

}  // namespace palpate::sim

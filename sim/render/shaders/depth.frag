#version 450 core
// Writes only depth, for shadow maps and depth pictures.
void main() {}

#version 450 core
// Only depth, for shadow maps and depth pictures.
void main() {}

// Graphs to begin with.
'use strict';
const EXAMPLES = {
  'Plastic': { version: 1, nodes: { s: { type: 'alSurface', params: { diffuseColor: [0.8, 0.25, 0.08], specular1Roughness: 0.25 } } }, outputs: { surface: { node: 's' } } },
  'Brushed copper': { version: 1, nodes: {
    s: { type: 'ShaderNodeBsdfPrincipled', params: { 'Base Color': [0.93, 0.49, 0.29, 1], Metallic: 1, Roughness: 0.28, Anisotropic: 0.7 } } }, outputs: { surface: { node: 's' } } },
  'Glass': { version: 1, nodes: { s: { type: 'ShaderNodeBsdfGlass', params: { Roughness: 0.02, IOR: 1.5, Color: [0.85, 0.97, 0.92, 1] } } }, outputs: { surface: { node: 's' } } },
  'Marble': { version: 1, nodes: {
    noise: { type: 'ShaderNodeTexNoise', params: { Scale: 3, Detail: 8, Distortion: 1.4 } },
    ramp: { type: 'ShaderNodeMix', params: { data_type: 'RGBA', Factor_Float: { node: 'noise', output: 'Fac' }, A_Color: [0.9, 0.88, 0.84, 1], B_Color: [0.08, 0.1, 0.12, 1] } },
    s: { type: 'ShaderNodeBsdfPrincipled', params: { 'Base Color': { node: 'ramp', output: 'Result_Color' }, Roughness: 0.15 } } }, outputs: { surface: { node: 's' } } },
  'Car paint': { version: 1, nodes: { s: { type: 'alSurface', params: { diffuseColor: [0.35, 0.02, 0.03], specular1Strength: 1, specular1Roughness: 0.05, specular2Strength: 0.8, specular2Color: [0.9, 0.3, 0.2], specular2Roughness: 0.4 } } }, outputs: { surface: { node: 's' } } },
  'Skin': { version: 1, nodes: { s: { type: 'ShaderNodeSubsurfaceScattering', params: { Color: [0.85, 0.52, 0.4, 1], Scale: 0.15, Radius: [1, 0.35, 0.2] } } }, outputs: { surface: { node: 's' } } },
  'Glow': { version: 1, nodes: { s: { type: 'ShaderNodeEmission', params: { Color: [0.3, 0.6, 1, 1], Strength: 2 } } }, outputs: { surface: { node: 's' } } },
};

// Light and air: a gradient sky, a sun in the north-west as on relief maps, and haze in the colour of the horizon.

import {BackSide, Color, DirectionalLight, Fog, HemisphereLight, Mesh, Scene, ShaderMaterial, SphereGeometry} from 'three';

const zenith = new Color(0x3f78b5);
const horizon = new Color(0xcfdde6);
const below = new Color(0xaab7bb);

export class Sky {
  private readonly sun = new DirectionalLight(0xfff4e2);
  private readonly ambient = new HemisphereLight(0xe8f1ff, 0x8d8a80);
  private readonly fog = new Fog(horizon);

  constructor(scene: Scene) {
    const dome = new Mesh(new SphereGeometry(1, 32, 24), domeMaterial());
    dome.renderOrder = -1;
    dome.frustumCulled = false;
    scene.add(dome, this.sun, this.ambient);
    scene.fog = this.fog;
    this.setRelief(false);
  }

  /** Flat ground has brightness 1 under the photo light; the relief light is lower and harder. */
  setRelief(relief: boolean): void {
    const elevation = ((relief ? 35 : 50) * Math.PI) / 180;
    const horizontal = Math.cos(elevation) * Math.SQRT1_2;
    this.sun.position.set(-horizontal, horizontal, Math.sin(elevation));
    // Lambert reflects irradiance / pi.
    this.sun.intensity = (relief ? 0.75 : 0.45) * (Math.PI / Math.sin(elevation));
    this.ambient.intensity = (relief ? 0.4 : 0.58) * Math.PI;
  }

  setHazeRange(near_m: number, far_m: number): void {
    this.fog.near = near_m;
    this.fog.far = far_m;
  }
}

/** Drawn around the camera behind everything else. The gradient follows the direction of view, not the distance. */
function domeMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    side: BackSide,
    depthTest: false,
    depthWrite: false,
    fog: false,
    uniforms: {zenith: {value: zenith}, horizon: {value: horizon}, below: {value: below}},
    vertexShader: `
      varying vec3 direction;
      void main() {
        direction = position;
        gl_Position = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
        gl_Position.z = 0.0;
      }`,
    fragmentShader: `
      uniform vec3 zenith, horizon, below;
      varying vec3 direction;
      void main() {
        float up = normalize(direction).z;
        vec3 color = up > 0.0 ? mix(horizon, zenith, pow(up, 0.55)) : mix(horizon, below, min(1.0, -up * 4.0));
        gl_FragColor = vec4(color, 1.0);
        #include <colorspace_fragment>
      }`,
  });
}

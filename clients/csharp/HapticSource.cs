// Unity: what vibrates.

using HapticTracer;
using UnityEngine;

namespace HapticTracing
{
    /// <summary>What vibrates on the nearest HapticObject above it, where it stands.</summary>
    public sealed class HapticSource : MonoBehaviour
    {
        [Range(0, 1)] public float amplitude = 1;
        [Tooltip("Hertz of its tone, without a clip"), Range(1, 1000)] public int frequency = 60;
        [Tooltip("Its vibration, in place of a tone")] public AudioClip clip;
        [Tooltip("Play only when Play is called")] public bool once;

        Source source;

        void Start()
        {
            source = HapticWorld.Tracer.Sources.Find(item => item.Name == name);
            if (source != null) return;
            source = new Source { On = GetComponentInParent<HapticObject>().Traced, Once = once, Signal = Made() };
            HapticWorld.Tracer.Sources.Add(source);
        }

        Signal Made()
        {
            var rate = HapticWorld.Tracer.SampleRate;
            if (clip == null) return once ? Signal.Tone(frequency, 0.03, rate) : Signal.Tone(frequency, rate: rate);
            var all = new float[clip.samples * clip.channels];
            clip.GetData(all, 0);
            var samples = new float[(int)(clip.length * rate)];
            for (var i = 0; i < samples.Length; i++) samples[i] = all[(int)((double)i * clip.frequency / rate) * clip.channels];
            return new Signal(samples, !once);
        }

        public void Play() { HapticWorld.Tracer.Play(source); }

        void FixedUpdate()
        {
            source.Amplitude = amplitude;
            source.Position = source.On.ToLocal(HapticWorld.At(transform.position));
        }

        void OnDisable() { if (source != null) source.Amplitude = 0; }

        void OnDestroy() { if (source != null && source.Name == "") HapticWorld.Tracer.Remove(source); }
    }
}

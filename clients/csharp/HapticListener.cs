// Unity: where it is felt.

using HapticTracer;
using UnityEngine;

namespace HapticTracing
{
    /// <summary>Where it is felt, on the nearest HapticObject above it. Shakes the gamepad, and gives levels and samples.</summary>
    [DefaultExecutionOrder(1000)]
    public sealed class HapticListener : MonoBehaviour
    {
        [Tooltip("Metres from its middle within which it is felt at once"), Range(0, 1)] public float radius = 0.05f;
        [Range(0, 10)] public float gain = 1;
        [Tooltip("Rumble with its level, if the Input System is there")] public bool rumble;

        Listener listener;

        /// <summary>Decibels of full scale, NaN for silence.</summary>
        public double Level { get { return HapticWorld.Tracer.Level(HapticWorld.Tracer.Listeners.IndexOf(listener)); } }
        /// <summary>The samples of the last step, of which the first Tracer.Count are valid.</summary>
        public float[] Samples { get { return listener.Samples; } }

        void Start()
        {
            var listeners = HapticWorld.Tracer.Listeners;
            listener = listeners.Find(item => item.Name == name);
            if (listener == null) listeners.Add(listener = new Listener { On = GetComponentInParent<HapticObject>().Traced, Radius = radius, Gain = gain });
        }

        void OnDestroy() { if (listener != null && listener.Name == "") HapticWorld.Tracer.Listeners.Remove(listener); }

        void FixedUpdate()
        {
            listener.Position = listener.On.ToLocal(HapticWorld.At(transform.position));
            HapticWorld.Step();
#if ENABLE_INPUT_SYSTEM
            if (!rumble) return;
            var level = Level;
            var shaken = double.IsNaN(level) ? 0f : Mathf.Min((float)System.Math.Pow(10, level / 20) * 1.414f, 1);
            UnityEngine.InputSystem.Gamepad.current?.SetMotorSpeeds(shaken, shaken);
#endif
        }
    }
}

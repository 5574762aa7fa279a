// Unity: moves what has the names of the scene, and rumbles the gamepad. Put it on any object of the scene.

using System.Collections.Generic;
using UnityEngine;

namespace HapticTracing
{
    public sealed class HapticTracingBehaviour : MonoBehaviour
    {
        [Tooltip("The address that haptic-tracing serve prints")] public string url = "ws://127.0.0.1:7710";
        [Tooltip("The token that it prints, for its devices to play")] public string token = "";
        [Tooltip("The listener whose level shakes the gamepad, if the Input System is there")] public string felt = "hand.R";

        readonly Dictionary<string, Transform> found = new Dictionary<string, Transform>();
        Client client;
        int known;

        async void OnEnable()
        {
            client = new Client();
            client.Failed += (where, message) => Debug.LogWarning($"Haptic Tracing: {where} {message}");
            client.Levels += levels => Shake(levels.TryGetValue(felt, out var level) ? (float)level.Amplitude : 0f);
            var hello = new Dictionary<string, object> { { "up", "y" }, { "handedness", "left" } };
            if (token != "") hello["token"] = token;
            try { await client.ConnectAsync(url, hello); }
            catch (System.Exception error) { Debug.LogWarning($"Haptic Tracing: {url}: {error.Message}"); }
        }

        void OnDisable()
        {
            Shake(0f);
            client?.Dispose();
        }

        void LateUpdate()
        {
            client.Update();
            if (!client.IsConnected) return;
            if (known != client.Objects.Count) Find();
            foreach (var pair in found)
            {
                if (pair.Value == null) continue;
                Vector3 p = pair.Value.position;
                Quaternion q = pair.Value.rotation;
                client.Move(pair.Key, p.x, p.y, p.z, q.w, q.x, q.y, q.z);
            }
            client.Step(Time.timeAsDouble);
        }

        void Find()
        {
            known = client.Objects.Count;
            found.Clear();
            foreach (var name in client.Objects)
            {
                var one = GameObject.Find(name);
                if (one != null) found[name] = one.transform;
            }
        }

        static void Shake(float amplitude)
        {
#if ENABLE_INPUT_SYSTEM
            UnityEngine.InputSystem.Gamepad.current?.SetMotorSpeeds(amplitude, amplitude);
#endif
        }
    }
}

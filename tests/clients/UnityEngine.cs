// What the components use of Unity, as its reference declares it, so that they compile without it.

using System;
using System.Collections.Generic;

namespace UnityEngine
{
    public struct Vector3
    {
        public float x, y, z;
        public static Vector3 zero { get { throw null; } }
        public Vector3 normalized { get { throw null; } }
        public float magnitude { get { throw null; } }
        public static float Dot(Vector3 a, Vector3 b) { throw null; }
        public static Vector3 operator +(Vector3 a, Vector3 b) { throw null; }
        public static Vector3 operator /(Vector3 a, float b) { throw null; }
    }

    public struct Quaternion { public float x, y, z, w; }
    public class Object
    {
        public string name { get; set; }
        public int GetInstanceID() { throw null; }
        public static bool operator ==(Object a, Object b) { throw null; }
        public static bool operator !=(Object a, Object b) { throw null; }
        public override bool Equals(object other) { throw null; }
        public override int GetHashCode() { throw null; }
    }

    public class Component : Object
    {
        public Transform transform { get { throw null; } }
        public T GetComponent<T>() { throw null; }
        public T GetComponentInParent<T>() { throw null; }
    }

    public class Transform : Component
    {
        public Vector3 position { get; set; }
        public Quaternion rotation { get; set; }
    }

    public class GameObject : Object
    {
        public Transform transform { get { throw null; } }
        public static GameObject Find(string name) { throw null; }
    }

    public static class Debug { public static void LogWarning(object message) { } }
    public class MonoBehaviour : Component { }
    public class Collider : Component { }
    public class Rigidbody : Component
    {
        public bool isKinematic { get; set; }
        public float mass { get; set; }
    }

    public struct ContactPoint
    {
        public Vector3 point { get { throw null; } }
        public Vector3 normal { get { throw null; } }
    }

    public class Collision
    {
        public Collider collider { get { throw null; } }
        public Vector3 relativeVelocity { get { throw null; } }
        public Vector3 impulse { get { throw null; } }
        public ContactPoint GetContact(int index) { throw null; }
        public int GetContacts(List<ContactPoint> contacts) { throw null; }
    }

    public class TextAsset : Object { public string text { get { throw null; } } }
    public class AudioClip : Object
    {
        public int samples { get { throw null; } }
        public int channels { get { throw null; } }
        public int frequency { get { throw null; } }
        public float length { get { throw null; } }
        public bool GetData(float[] data, int offset) { throw null; }
    }

    public static class Time
    {
        public static float fixedTime { get { throw null; } }
        public static float fixedDeltaTime { get { throw null; } }
        public static double timeAsDouble { get { throw null; } }
    }

    public static class Mathf { public static float Min(float a, float b) { throw null; } }
    public class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    public class RangeAttribute : Attribute { public RangeAttribute(float min, float max) { } }
    public class DefaultExecutionOrder : Attribute { public DefaultExecutionOrder(int order) { } }
    public enum RuntimeInitializeLoadType { SubsystemRegistration }
    public class RuntimeInitializeOnLoadMethodAttribute : Attribute { public RuntimeInitializeOnLoadMethodAttribute(RuntimeInitializeLoadType type) { } }
}

namespace UnityEngine.InputSystem
{
    public class Gamepad
    {
        public static Gamepad current { get { throw null; } }
        public void SetMotorSpeeds(float low, float high) { }
    }
}
